"""The compiled twin of the encoder of texts: what reads, without torch. It agrees with torch to 1e-4, always with the same bits."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.networks.kernels import Floats, add_and_normalise, attend, gelu, linear
from roadmend.networks.shape import TextShape

Tensors = Mapping[str, NDArray[Any]]

_SCALE = ".scale"  # behind the name of a tensor whose rows were rounded


class TextReader:
    """Turns the pieces of a text into vectors, as networks.encoder.TextEncoder does.

    Args:
        shape: of the encoder.
        tensors: of the encoder by their names in torch.
        prefix: what stands before these names.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, shape: TextShape, tensors: Tensors, prefix: str = "encoder.") -> None:
        self.shape = shape
        width, inner = shape.hidden, shape.feed_forward
        names = {
            "pieces.weight": (shape.pieces, width),
            "positions.weight": (shape.positions, width),
            "marks.weight": (shape.marks, width),
            "norm.weight": (width,),
            "norm.bias": (width,),
        }
        for place in range(shape.layers):
            for part, rows, columns in (
                ("attention_in", 3 * width, width),
                ("attention_out", width, width),
                ("feed_in", inner, width),
                ("feed_out", width, inner),
            ):
                names |= {f"layers.{place}.{part}.weight": (rows, columns), f"layers.{place}.{part}.bias": (rows,)}
            names |= {
                f"layers.{place}.{norm}.{part}": (width,) for norm in ("norm1", "norm2") for part in ("weight", "bias")
            }
        self._tensors = {name: take(tensors, prefix + name, sizes) for name, sizes in names.items()}
        for name, values in self._tensors.items():
            if name.startswith("layers.") and values.ndim > 1:
                self._tensors[name] = np.ascontiguousarray(values.T)  # as the kernels take it

    def read(self, pieces: NDArray[np.int64], marks: NDArray[np.int64]) -> Floats:
        """Return what each piece has come to mean, (T, H) float32.

        Args:
            pieces: (T,), 1 <= T <= ``shape.positions``, each below ``shape.pieces``.
            marks: (T,), each below ``shape.marks``.

        Raises:
            ValueError: there is none, or there are more than the encoder has positions.
        """
        if not 1 <= len(pieces) <= self.shape.positions:
            raise ValueError(f"pieces: 1 to {self.shape.positions} wanted, got {len(pieces)}")
        own = self._tensors
        states = own["pieces.weight"][pieces] + own["positions.weight"][: len(pieces)] + own["marks.weight"][marks]
        self._add(states, np.zeros_like(states), "norm")
        for place in range(self.shape.layers):
            self._layer(states, f"layers.{place}.")
        return states

    def _layer(self, states: Floats, name: str) -> None:
        """Transform the states (T, H), in place."""
        count, width = states.shape
        mapped = self._mapped(states, f"{name}attention_in", 3 * width)
        query, keys, values = (np.ascontiguousarray(part) for part in np.split(mapped, 3, axis=1))
        query *= np.float32((width // self.shape.heads) ** -0.5)
        seen, weights = np.empty_like(query), np.empty((self.shape.heads, count), np.float32)
        attend(query, np.ascontiguousarray(keys.T), values, self.shape.heads, seen, weights)
        self._add(states, self._mapped(seen, f"{name}attention_out", width), f"{name}norm1")
        inner = self._mapped(states, f"{name}feed_in", self.shape.feed_forward)
        gelu(inner)
        self._add(states, self._mapped(inner, f"{name}feed_out", width), f"{name}norm2")

    def _mapped(self, values: Floats, name: str, width: int) -> Floats:
        mapped = np.empty((len(values), width), np.float32)
        linear(values, self._tensors[f"{name}.weight"], self._tensors[f"{name}.bias"], mapped)
        return mapped

    def _add(self, states: Floats, added: Floats, norm: str) -> None:
        add_and_normalise(states, added, self._tensors[f"{norm}.weight"], self._tensors[f"{norm}.bias"])


def take(tensors: Tensors, name: str, sizes: tuple[int, ...]) -> Floats:
    """A tensor of a model as float32.

    Raises:
        ValueError: it is missing, has another shape or holds what is not finite.
    """
    if name not in tensors:
        raise ValueError(f"{name} is missing")
    found = tensors[name]
    if found.shape != sizes:
        raise ValueError(f"{name}: shape {sizes} wanted, got {found.shape}")
    values: Floats = found.astype(np.float32)
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds what is not finite")
    return values


def rounded(tensors: Tensors) -> dict[str, NDArray[Any]]:
    """Tensors for a file of a quarter of the size: each row of a matrix as whole numbers up to 127, beside its scale."""
    found: dict[str, NDArray[Any]] = {}
    for name, values in tensors.items():
        if values.ndim != 2:
            found[name] = values.astype(np.float32)
            continue
        scale = np.maximum(np.abs(values).max(axis=1), np.finfo(np.float32).tiny) / 127
        found[name] = np.rint(values / scale[:, None]).astype(np.int8)
        found[name + _SCALE] = scale.astype(np.float32)
    return found


def restored(tensors: Tensors) -> dict[str, NDArray[Any]]:
    """Tensors as they were before :func:`rounded`, but for the rounding.

    Raises:
        ValueError: a scale is missing or does not fit.
    """
    found = {name: values for name, values in tensors.items() if not name.endswith(_SCALE)}
    for name, values in found.items():
        if values.dtype == np.int8:
            found[name] = values.astype(np.float32) * take(tensors, name + _SCALE, values.shape[:1])[:, None]
    return found
