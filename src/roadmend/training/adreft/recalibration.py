"""Makes probabilities of what networks say that were taught on other weights than the world has.

A monitor that hears violations more often than they occur says too much, in the adapter's danger as in its own score.
Both are set right by a logistic regression of what was seen on the logit (Platt 1999), on moments of drives that were
not learned from, and that is folded into the last layer: the networks stay as they are built, and so does the order of
the scores.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.weighing import DANGER

Floats = NDArray[np.float64]
Tensors = Mapping[str, NDArray[Any]]

_STEPS = 100
_RIDGE = 1e-3  # holds the two numbers to 1 and 0 where the moments say little
_LEAST = 0.05  # of the slope: the order of the scores is never turned


def fit_logits(logits: Floats, seen: Floats, weight: Floats) -> tuple[float, float]:
    """Slope and offset that make a probability of a logit.

    Args:
        logits: shape (F,).
        seen: share of futures that violate, shape (F,).
        weight: shape (F,).
    """
    weight = weight / weight.sum()
    design = np.stack([logits, np.ones_like(logits)])
    found = np.array([1.0, 0.0])
    for _ in range(_STEPS):
        chances = sigmoids(found @ design)
        slope = design @ (weight * (chances - seen)) + _RIDGE * (found - [1.0, 0.0])
        bend = (design * (weight * chances * (1.0 - chances))) @ design.T + _RIDGE * np.eye(2)
        step = np.linalg.solve(bend, slope)
        found -= step / max(1.0, float(np.abs(step).max()))  # a Newton step, at most 1 long
        found[0] = max(_LEAST, found[0])
    return float(found[0]), float(found[1])


def sigmoids(logits: Floats) -> Floats:
    """1 / (1 + exp(-logit)), shape (F,)."""
    chances: Floats = 1.0 / (1.0 + np.exp(-np.clip(logits, -60.0, 60.0)))
    return chances


def fold(
    model: ModelConfiguration, tensors: Tensors, monitor: tuple[float, float], danger: tuple[float, float]
) -> dict[str, NDArray[Any]]:
    """Tensors of the same networks whose monitor's logit and danger are ``slope * logit + offset``.

    Args:
        model: what they are built from.
        tensors: of the networks.
        monitor: slope and offset.
        danger: slope and offset.
    """
    changed = dict(tensors)
    for head, row, (slope, offset), layers in (
        ("monitor", 0, monitor, len(model.monitor_shape.widths) - 1),
        ("adapter", DANGER, danger, len(model.adapter_shape.widths) - 1),
    ):
        for part, added in (("weight", 0.0), ("bias", offset)):
            name = f"{head}.layers.{layers - 1}.{part}"
            values = np.array(changed[name])
            values[row] = slope * values[row] + added
            changed[name] = values
    return changed
