"""The compiled twins of SceneEncoder and Head: what drives, without torch. They agree with torch to 2e-5."""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.networks.checkpoint import Tensors
from roadmend.networks.kernels import Floats, add_and_normalise, attend, gelu, linear, rectify
from roadmend.networks.kernels import sigmoid as _sigmoid
from roadmend.networks.shape import EncoderShape, HeadShape
from roadmend.networks.tensors import linear_map, take


class CompiledEncoder:
    """Turns the tokens of a scene into its state, as SceneEncoder does.

    Args:
        shape: of the encoder.
        tensors: of the encoder by their names in torch.
        prefix: what stands before these names.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, shape: EncoderShape, tensors: Tensors, prefix: str = "encoder.") -> None:
        self.shape = shape
        self._weights = _pack_encoder(shape, tensors, prefix)
        with_gelu = shape.activation == "gelu"
        self._sizes = (shape.hidden, shape.layers, shape.heads, shape.feed_forward, with_gelu)
        self._attention = np.zeros((shape.heads, 1), np.float32)

    def encode(self, tokens: NDArray[np.float32]) -> Floats:
        """Return the state of a scene, (H,) float32.

        Args:
            tokens: (N, c), any N >= 0.

        Raises:
            ValueError: the tokens have another shape. What is not finite in them makes the whole state NaN.
        """
        shape = self.shape
        if tokens.ndim != 2 or tokens.shape[1] != shape.attributes:
            raise ValueError(f"tokens: shape (N, {shape.attributes}) wanted, got {tokens.shape}")
        state = np.empty(shape.hidden, np.float32)
        self._attention = np.empty((shape.heads, tokens.shape[0] + 1), np.float32)
        _encode(plain(tokens), self._weights, self._sizes, state, self._attention)
        return state

    @property
    def attention(self) -> Floats:
        """How much [CLS] looked at each token in the last layer of the last call, (N,), averaged over the heads.

        The sum is at most 1: the rest is its look at itself.
        """
        average: Floats = np.add.reduce(self._attention[:, 1:], axis=0) / np.float32(self.shape.heads)
        return average


class CompiledHead:
    """A multi-layer perceptron, as Head is.

    Args:
        shape: of the head.
        tensors: of the head by their names in torch.
        prefix: what stands before these names, such as "monitor.".

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, shape: HeadShape, tensors: Tensors, prefix: str) -> None:
        self.shape = shape
        self._weights = pack_perceptron(shape, tensors, prefix)
        self._widths = np.array(shape.widths)

    def apply(self, inputs: NDArray[np.float32]) -> Floats:
        """Return the raw outputs, (outputs,) float32, for inputs (inputs,).

        Raises:
            ValueError: the inputs have another shape. What is not finite in them makes all outputs NaN.
        """
        if inputs.shape != (self.shape.inputs,):
            raise ValueError(f"inputs: shape ({self.shape.inputs},) wanted, got {inputs.shape}")
        return _apply(plain(inputs), self._weights, self._widths)


def sigmoid(x: float) -> float:
    """The logistic function in float32: the same bits on every processor, which math.exp does not promise."""
    return float(_sigmoid(np.float32(x)))


def pack_perceptron(shape: HeadShape, tensors: Tensors, prefix: str) -> Floats:
    """All weights of a perceptron in one array, layer by layer.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """
    parts = list[Floats]()
    for place, (inputs, outputs) in enumerate(pairwise(shape.widths)):
        parts += linear_map(tensors, f"{prefix}layers.{place}", outputs, inputs)
    return np.concatenate([part.ravel() for part in parts])


def plain(values: NDArray[Any]) -> Floats:
    """The one kind of array that the kernels are compiled for.

    Another kind, be it only read-only, would wait for the compiler in the middle of a drive.
    """
    result: Floats = np.ascontiguousarray(values, np.float32)
    return result if result.flags.writeable else result.copy()


def _pack_encoder(shape: EncoderShape, tensors: Tensors, prefix: str) -> Floats:
    """All weights in one array, in the order in which _encode takes them."""
    width, inner = shape.hidden, shape.feed_forward
    parts = [*linear_map(tensors, f"{prefix}embed", width, shape.attributes), take(tensors, f"{prefix}cls", width)]
    scale = np.float32((width // shape.heads) ** -0.5)
    for place in range(shape.layers):
        name = f"{prefix}layers.{place}."
        weight, bias = linear_map(tensors, f"{name}attention_in", 3 * width, width)
        # The scale of the attention goes into the queries here, once.
        parts += [weight[:, :width] * scale, bias[:width] * scale]
        parts += [weight[:, width:], bias[width:]]
        parts += linear_map(tensors, f"{name}attention_out", width, width)
        parts += [take(tensors, f"{name}norm1.{part}", width) for part in ("weight", "bias")]
        parts += linear_map(tensors, f"{name}feed_in", inner, width)
        parts += linear_map(tensors, f"{name}feed_out", width, inner)
        parts += [take(tensors, f"{name}norm2.{part}", width) for part in ("weight", "bias")]
    return np.concatenate([part.ravel() for part in parts])


@compiled
def _encode(
    tokens: Floats,
    weights: Floats,
    sizes: tuple[int, int, int, int, bool],
    state: Floats,
    attention: Floats,
) -> None:
    """Fill state (H,) and attention (heads, N + 1) from tokens (N, c).

    ``sizes`` are the width, the layers, the heads, the width between of the feed-forward part, and whether that
    rectifies by GELU.
    """
    width, layers, heads, inner, with_gelu = sizes
    count, attributes = tokens.shape
    size = count + 1
    states = np.empty((size, width), np.float32)
    at = attributes * width
    linear(tokens, weights[:at].reshape(attributes, width), weights[at : at + width], states[1:])
    at += width
    states[0] = weights[at : at + width]
    at += width

    pairs = np.empty((size, 2 * width), np.float32)  # a token's key, then its value
    keys = np.empty((width, size), np.float32)
    for place in range(layers):
        # After the last layer nobody asks for any token but [CLS].
        wanted = states[:1] if place == layers - 1 else states
        rows = wanted.shape[0]
        query = np.empty((rows, width), np.float32)
        linear(wanted, weights[at : at + width * width].reshape(width, width), weights[at + width * width :], query)
        at += (width + 1) * width
        weight = weights[at : at + 2 * width * width].reshape(width, 2 * width)
        linear(states, weight, weights[at + 2 * width * width :], pairs)
        at += (width + 1) * 2 * width
        for t in range(size):
            for j in range(width):
                keys[j, t] = pairs[t, j]
        seen = np.empty((rows, width), np.float32)
        attend(query, keys, pairs[:, width:], heads, seen, attention)

        linear(seen, weights[at : at + width * width].reshape(width, width), weights[at + width * width :], query)
        at += (width + 1) * width
        add_and_normalise(wanted, query, weights[at : at + width], weights[at + width : at + 2 * width])
        at += 2 * width
        between = np.empty((rows, inner), np.float32)
        linear(wanted, weights[at : at + width * inner].reshape(width, inner), weights[at + width * inner :], between)
        at += (width + 1) * inner
        if with_gelu:
            gelu(between)
        else:
            rectify(between)
        linear(between, weights[at : at + inner * width].reshape(inner, width), weights[at + inner * width :], query)
        at += (inner + 1) * width
        add_and_normalise(wanted, query, weights[at : at + width], weights[at + width : at + 2 * width])
        at += 2 * width

    poison = _poison(tokens.ravel())
    for j in range(width):
        state[j] = states[0, j] + poison


@compiled
def _apply(inputs: Floats, weights: Floats, widths: NDArray[np.int64]) -> Floats:
    values = inputs.reshape(1, inputs.size)
    at = 0
    last = widths.size - 2
    for place in range(last + 1):
        size = widths[place] * widths[place + 1]
        results = np.empty((1, widths[place + 1]), np.float32)
        weight = weights[at : at + size].reshape(widths[place], widths[place + 1])
        linear(values, weight, weights[at + size :], results)
        if place < last:
            rectify(results)
        at += size + widths[place + 1]
        values = results
    poison = _poison(inputs)
    for j in range(values.shape[1]):
        values[0, j] += poison
    result: Floats = values[0]
    return result


@compiled
def _poison(values: Floats) -> np.float32:
    """0 where all values are finite, else NaN."""
    result = np.float32(0.0)
    for value in values:
        result += value - value
    return result
