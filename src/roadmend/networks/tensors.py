"""The tensors of a model file: taken out with a look at each, and rounded for a smaller file."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.networks.checkpoint import Tensors
from roadmend.networks.kernels import Floats

_SCALE = ".scale"  # behind the name of a tensor whose rows were rounded


def take(tensors: Tensors, name: str, *shape: int) -> Floats:
    """One tensor as float32.

    Raises:
        ValueError: it is missing, has another shape or holds what is not finite.
    """
    if name not in tensors:
        raise ValueError(f"tensor {name} is missing")
    tensor = tensors[name]
    if tensor.shape != shape:
        raise ValueError(f"tensor {name}: shape {shape} wanted, got {tensor.shape}")
    result: Floats = np.ascontiguousarray(tensor, np.float32)
    if not np.isfinite(result).all():
        raise ValueError(f"tensor {name} holds what is not finite")
    return result


def linear_map(tensors: Tensors, name: str, outputs: int, inputs: int) -> tuple[Floats, Floats]:
    """A linear map as the kernels want it: the weight as (inputs, outputs), torch has it the other way, and the bias.

    Raises:
        ValueError: one of the two is missing, has another shape or holds what is not finite.
    """
    weight = take(tensors, f"{name}.weight", outputs, inputs)
    return np.ascontiguousarray(weight.T), take(tensors, f"{name}.bias", outputs)


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
            found[name] = values.astype(np.float32) * take(tensors, name + _SCALE, len(values))[:, None]
    return found
