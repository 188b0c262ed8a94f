"""Elementary functions of arrays that give the same bits on every processor.

NumPy's own choose an implementation by the processor's instruction set, and those differ in the last bit: the same
episode would have another digest on another machine. These ask the C library, element by element. They are for what
decides how an episode goes and is worked out seldom or over a few values; kernels have the C library's anyway.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def sin(angles: Floats) -> Floats:
    """Sines of angles [rad], of the same shape."""
    return _shaped(map(math.sin, angles.ravel().tolist()), angles)


def cos(angles: Floats) -> Floats:
    """Cosines of angles [rad], of the same shape."""
    return _shaped(map(math.cos, angles.ravel().tolist()), angles)


def atan2(y: Floats, x: Floats) -> Floats:
    """Angles [rad] of the directions (x, y), two arrays of one shape, -pi .. pi, of that shape."""
    return _shaped(map(math.atan2, y.ravel().tolist(), x.ravel().tolist()), y)


def exp(exponents: Floats) -> Floats:
    """Powers of e, of the same shape.

    Raises:
        OverflowError: an exponent is above 709.
    """
    return _shaped(map(math.exp, exponents.ravel().tolist()), exponents)


def power(bases: Floats, exponent: float) -> Floats:
    """Powers of bases that are not negative, of the same shape."""
    return _shaped((math.pow(base, exponent) for base in bases.ravel().tolist()), bases)


def _shaped(values: Iterable[float], like: ArrayLike) -> Floats:
    array = np.asarray(like)
    return np.fromiter(values, np.float64, array.size).reshape(array.shape)
