"""How far two decoded messages are apart, field by field."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np


def deviations(first: Any, second: Any) -> dict[str, float]:
    """The fields that differ, with the largest difference of their numbers; those that only one of them has are left out.

    Args:
        first: a message, decoded.
        second: another of the same type, perhaps of another version of it.

    Returns:
        By the field's name, such as ``pose.pose.position.x`` or ``markers[].id``: the absolute difference; infinite
        where it is not a matter of numbers: texts, lengths, NaN on one side. Two NaN are equal.
    """
    found: dict[str, float] = {}
    for name, size in _walk("", first, second):
        found[name] = max(size, found.get(name, 0.0))
    return found


def _walk(name: str, first: Any, second: Any) -> Iterator[tuple[str, float]]:
    if hasattr(first, "__dataclass_fields__"):
        for field in filter(second.__dataclass_fields__.__contains__, first.__dataclass_fields__):
            yield from _walk(f"{name}.{field}" if name else field, getattr(first, field), getattr(second, field))
    elif isinstance(first, np.ndarray | list | tuple):
        if len(first) != len(second):
            yield name, math.inf
        elif isinstance(first, np.ndarray) and first.dtype.kind in "biuf":
            size = _size(np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64))
            if size or not np.array_equal(first, second, equal_nan=first.dtype.kind == "f"):
                yield f"{name}[]", size or math.inf
        else:
            for one, other in zip(first, second, strict=True):
                yield from _walk(f"{name}[]", one, other)
    elif first != second and not (first != first and second != second):  # noqa: PLR0124 -- NaN
        is_number = isinstance(first, int | float) and isinstance(second, int | float)
        size = abs(float(first) - float(second)) if is_number else math.inf
        yield name, math.inf if math.isnan(size) else size


def _size(first: Any, second: Any) -> float:
    """The largest difference of two arrays of one shape."""
    if not len(first):
        return 0.0
    with np.errstate(invalid="ignore"):
        sizes = np.abs(first - second)
    sizes[first == second] = 0.0  # infinities among them
    sizes[np.isnan(first) & np.isnan(second)] = 0.0
    sizes[np.isnan(sizes)] = math.inf
    return float(sizes.max())
