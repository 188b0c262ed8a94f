"""The compiled twins of SetEncoder and Excerpt: what drives, without torch."""

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.networks.checkpoint import Tensors
from roadmend.networks.compiled_encoder import pack_perceptron, plain
from roadmend.networks.kernels import Floats, linear, rectify
from roadmend.networks.shape import ExcerptShape, SetShape


class CompiledSetEncoder:
    """Turns the tokens of a scene into its state, as SetEncoder does.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, shape: SetShape, tensors: Tensors, prefix: str = "encoder.") -> None:
        self.shape = shape
        self._weights = pack_perceptron(shape.token_shape, tensors, f"{prefix}token.")
        self._widths = np.array(shape.token_shape.widths)

    def encode(self, tokens: NDArray[np.float32]) -> Floats:
        """Return the state of a scene, (2 H,) float32.

        Args:
            tokens: (N, c), N >= 1. What is not finite in them makes the state NaN.

        Raises:
            ValueError: the tokens have another shape.
        """
        if tokens.ndim != 2 or not len(tokens) or tokens.shape[1] != self.shape.attributes:
            raise ValueError(f"tokens: shape (N, {self.shape.attributes}) with N >= 1 wanted, got {tokens.shape}")
        return _encode(plain(tokens), self._weights, self._widths)


class CompiledExcerpt:
    """Takes out of the tokens of a scene what the shape names, as Excerpt does."""

    def __init__(self, shape: ExcerptShape, tensors: Tensors, prefix: str = "encoder.") -> None:  # noqa: ARG002 - as all
        self.shape = shape
        self._tokens, self._columns = np.array(shape.places).T

    def encode(self, tokens: NDArray[np.float32]) -> Floats:
        """Return the values, (places,) float32, of tokens (N, c).

        Raises:
            ValueError: the tokens have another shape, or one that is named is not there.
        """
        if tokens.ndim != 2 or tokens.shape[1] != self.shape.attributes or len(tokens) <= self._tokens.max():
            raise ValueError(f"tokens: at least {self._tokens.max() + 1} of {self.shape.attributes} wanted")
        return np.asarray(tokens[self._tokens, self._columns], dtype=np.float32)


@compiled
def _encode(tokens: Floats, weights: Floats, widths: NDArray[np.int64]) -> Floats:
    count = tokens.shape[0]
    values = tokens
    at = 0
    for place in range(widths.size - 1):
        size = widths[place] * widths[place + 1]
        results = np.empty((count, widths[place + 1]), np.float32)
        weight = weights[at : at + size].reshape(widths[place], widths[place + 1])
        linear(values, weight, weights[at + size :], results)
        rectify(results)
        at += size + widths[place + 1]
        values = results
    width = values.shape[1]
    state = np.empty(2 * width, np.float32)
    for j in range(width):
        largest = values[0, j]
        poison = np.float32(0.0)  # a comparison would let a NaN pass unseen
        for t in range(count):
            largest = max(largest, values[t, j])
            poison += values[t, j] - values[t, j]
        state[j] = largest + poison
        state[width + j] = values[0, j] + poison
    return state
