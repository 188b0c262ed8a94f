"""The compiled twin of the encoder of texts: what reads, without torch, always with the same bits.

It agrees with networks.encoder.TextEncoder to 1e-4.
"""

import numpy as np
from numpy.typing import NDArray

from roadmend.networks.checkpoint import Tensors
from roadmend.networks.kernels import Floats, add_and_normalise, attend, gelu, linear
from roadmend.networks.shape import TextShape
from roadmend.networks.tensors import linear_map, take

_Map = tuple[Floats, Floats]  # a linear map's weight (inputs, outputs) and bias, or a norm's scale and shift


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
        self._pieces = take(tensors, f"{prefix}pieces.weight", shape.pieces, width)
        self._positions = take(tensors, f"{prefix}positions.weight", shape.positions, width)
        self._marks = take(tensors, f"{prefix}marks.weight", shape.marks, width)
        self._norm = _norm(tensors, f"{prefix}norm", width)
        self._layers = []
        for place in range(shape.layers):
            name = f"{prefix}layers.{place}."
            maps = {
                "attention_in": linear_map(tensors, f"{name}attention_in", 3 * width, width),
                "attention_out": linear_map(tensors, f"{name}attention_out", width, width),
                "norm1": _norm(tensors, f"{name}norm1", width),
                "feed_in": linear_map(tensors, f"{name}feed_in", inner, width),
                "feed_out": linear_map(tensors, f"{name}feed_out", width, inner),
                "norm2": _norm(tensors, f"{name}norm2", width),
            }
            self._layers.append(maps)

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
        states: Floats = self._pieces[pieces] + self._positions[: len(pieces)] + self._marks[marks]
        add_and_normalise(states, np.zeros_like(states), *self._norm)
        for maps in self._layers:
            self._transform(states, maps)
        return states

    def _transform(self, states: Floats, maps: dict[str, _Map]) -> None:
        """One layer's work on the states (T, H), in place."""
        count, width = states.shape
        query, keys, values = (
            np.ascontiguousarray(part) for part in np.split(_mapped(states, maps["attention_in"]), 3, axis=1)
        )
        query *= np.float32((width // self.shape.heads) ** -0.5)
        seen, weights = np.empty_like(query), np.empty((self.shape.heads, count), np.float32)
        attend(query, np.ascontiguousarray(keys.T), values, self.shape.heads, seen, weights)
        add_and_normalise(states, _mapped(seen, maps["attention_out"]), *maps["norm1"])
        inner = _mapped(states, maps["feed_in"])
        gelu(inner)
        add_and_normalise(states, _mapped(inner, maps["feed_out"]), *maps["norm2"])


def _norm(tensors: Tensors, name: str, width: int) -> _Map:
    return take(tensors, f"{name}.weight", width), take(tensors, f"{name}.bias", width)


def _mapped(values: Floats, by: _Map) -> Floats:
    weight, bias = by
    mapped = np.empty((len(values), len(bias)), np.float32)
    linear(values, weight, bias, mapped)
    return mapped
