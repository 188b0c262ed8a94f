"""The arithmetic of networks, compiled, in float32.

The same input gives the same bits on every processor: there is no BLAS, no vector mathematics library and no fused
multiply-add (the compiler may not contract without fast-math), every sum runs in the order in which it is written, and
exp and erf are polynomials of plain products and sums. The inner loops run over outputs that lie side by side, so the
compiler can use vector instructions of any width without touching that order.

What is not finite stays so: no comparison here turns a NaN into a number.
"""

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled

Floats = NDArray[np.float32]

EPSILON = np.float32(1e-5)  # of the layer norm, as in torch

_F = np.float32
_ZERO, _HALF, _ONE = _F(0.0), _F(0.5), _F(1.0)
# exp, after Cephes' expf: 2^n times a polynomial on [-ln 2 / 2, ln 2 / 2]. Adding 1.5 * 2^23 rounds to a whole number,
# which then stands in the low bits.
_LOG2_E = _F(1.44269504088896341)
_ROUND = _F(12582912.0)
_LN2_HIGH, _LN2_LOW = _F(0.693359375), _F(-2.12194440e-4)
_E0, _E1, _E2 = _F(1.9875691500e-4), _F(1.3981999507e-3), _F(8.3334519073e-3)
_E3, _E4, _E5 = _F(4.1665795894e-2), _F(1.6666665459e-1), _F(5.0000001201e-1)
_LOWEST = _F(-87.0)
# erf, Abramowitz and Stegun 7.1.26: |error| <= 1.5e-7 before rounding.
_R = _F(0.3275911)
_A1, _A2, _A3 = _F(0.254829592), _F(-0.284496736), _F(1.421413741)
_A4, _A5 = _F(-1.453152027), _F(1.061405429)
_SQRT_HALF = _F(0.70710678118654752)


@compiled
def exp(x: np.float32) -> np.float32:
    """e^x for x <= 0, with a relative error of at most 1e-7; below -87 it stays at e^-87 = 1.6e-38."""
    x = _LOWEST if x < _LOWEST else x  # noqa: FURB136 - so that NaN stays NaN
    shifted = x * _LOG2_E + _ROUND
    n = shifted - _ROUND
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    p = ((((_E0 * r + _E1) * r + _E2) * r + _E3) * r + _E4) * r + _E5
    power = np.int32((_F(shifted).view(np.int32) + np.int32(127)) << np.int32(23)).view(_F)
    return (p * (r * r) + r + _ONE) * power


@compiled
def erf(x: np.float32) -> np.float32:
    """The error function, with an absolute error of at most 6e-7."""
    size = abs(x)
    t = _ONE / (_ONE + _R * size)
    value = _ONE - ((((_A5 * t + _A4) * t + _A3) * t + _A2) * t + _A1) * t * exp(-size * size)
    return -value if x < _ZERO else value


@compiled
def sigmoid(x: np.float32) -> np.float32:
    """The logistic function 1 / (1 + e^-x)."""
    e = exp(-abs(x))
    return (e if x < _ZERO else _ONE) / (_ONE + e)


@compiled
def linear(inputs: Floats, weight: Floats, bias: Floats, outputs: Floats) -> None:
    """Map inputs (T, n) by weight (n, m) and bias (m,) to outputs (T, m).

    Every sum runs from the bias up through the inputs.
    """
    count, depth = inputs.shape
    width = weight.shape[1]
    for t in range(count):
        for j in range(width):
            outputs[t, j] = bias[j]
    # Eight rows of the weight serve all tokens while they are in the nearest cache, and every output is loaded and
    # stored once for eight products.
    whole = depth - depth % 8
    for k in range(0, whole, 8):
        w0, w1, w2, w3 = weight[k], weight[k + 1], weight[k + 2], weight[k + 3]
        w4, w5, w6, w7 = weight[k + 4], weight[k + 5], weight[k + 6], weight[k + 7]
        for t in range(count):
            out = outputs[t]
            x0, x1, x2, x3 = inputs[t, k], inputs[t, k + 1], inputs[t, k + 2], inputs[t, k + 3]
            x4, x5, x6, x7 = inputs[t, k + 4], inputs[t, k + 5], inputs[t, k + 6], inputs[t, k + 7]
            for j in range(width):
                s = out[j] + x0 * w0[j] + x1 * w1[j] + x2 * w2[j] + x3 * w3[j]
                out[j] = s + x4 * w4[j] + x5 * w5[j] + x6 * w6[j] + x7 * w7[j]
    for k in range(whole, depth):
        row = weight[k]
        for t in range(count):
            out = outputs[t]
            x0 = inputs[t, k]
            for j in range(width):
                out[j] += x0 * row[j]


@compiled
def rectify(values: Floats) -> None:
    """Set the negatives of (T, n) to 0, in place. What has overflown downwards becomes NaN, not 0."""
    for t in range(values.shape[0]):
        row = values[t]
        for j in range(row.size):
            x = row[j]
            row[j] = (_ZERO if x < _ZERO else x) + (x - x)  # noqa: FURB136 - so that NaN stays NaN


@compiled
def gelu(values: Floats) -> None:
    """Replace every x of (T, n) by x (1 + erf(x / sqrt 2)) / 2, in place."""
    for t in range(values.shape[0]):
        row = values[t]
        for j in range(row.size):
            x = row[j]
            row[j] = _HALF * x * (_ONE + erf(x * _SQRT_HALF))


@compiled
def add_and_normalise(values: Floats, added: Floats, scale: Floats, shift: Floats) -> None:
    """Add to values (T, n), then normalise each row, in place. A variance that overflows gives NaN."""
    width = values.shape[1]
    part = _F(width)
    for t in range(values.shape[0]):
        row, more = values[t], added[t]
        total = _ZERO
        for j in range(width):
            row[j] += more[j]
        for j in range(width):
            total += row[j]
        mean = total / part
        spread = _ZERO
        for j in range(width):
            row[j] -= mean
        for j in range(width):
            spread += row[j] * row[j]
        spread /= part
        factor = _ONE / np.sqrt(spread + EPSILON) + (spread - spread)
        for j in range(width):
            row[j] = row[j] * factor * scale[j] + shift[j]


@compiled
def attend(query: Floats, keys: Floats, values: Floats, heads: int, seen: Floats, weights: Floats) -> None:
    """Multi-head attention; the queries come scaled by 1 / sqrt(H / heads).

    Args:
        query: (Q, H), one row for each token that looks.
        keys: (H, T), turned, so that the tokens lie side by side.
        values: (T, H).
        heads: they share H evenly.
        seen: (Q, H), out: what each of the Q sees.
        weights: (heads, T), out: how much the last of the Q looks at each of the T.
    """
    count = values.shape[0]
    depth = query.shape[1] // heads
    for t in range(query.shape[0]):
        for h in range(heads):
            row = weights[h]
            for s in range(count):
                row[s] = _ZERO
            first = h * depth
            whole = first + depth - depth % 4
            for d in range(first, whole, 4):
                q0, q1, q2, q3 = query[t, d], query[t, d + 1], query[t, d + 2], query[t, d + 3]
                k0, k1, k2, k3 = keys[d], keys[d + 1], keys[d + 2], keys[d + 3]
                for s in range(count):
                    row[s] = row[s] + q0 * k0[s] + q1 * k1[s] + q2 * k2[s] + q3 * k3[s]
            for d in range(whole, first + depth):
                q0, k0 = query[t, d], keys[d]
                for s in range(count):
                    row[s] += q0 * k0[s]
            peak = row[0]
            for s in range(1, count):
                peak = max(row[s], peak)
            for s in range(count):
                row[s] = exp(row[s] - peak)
            total = _ZERO
            for s in range(count):
                total += row[s]
            for s in range(count):
                row[s] /= total
            out = seen[t, first : first + depth]
            for d in range(depth):
                out[d] = _ZERO
            whole = count - count % 4
            for s in range(0, whole, 4):
                p0, p1, p2, p3 = row[s], row[s + 1], row[s + 2], row[s + 3]
                v0, v1, v2, v3 = values[s, first:], values[s + 1, first:], values[s + 2, first:], values[s + 3, first:]
                for d in range(depth):
                    out[d] = out[d] + p0 * v0[d] + p1 * v1[d] + p2 * v2[d] + p3 * v3[d]
            for s in range(whole, count):
                p0, v0 = row[s], values[s, first:]
                for d in range(depth):
                    out[d] += p0 * v0[d]
