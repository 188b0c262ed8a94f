"""Leaves bystanders out of a scene at random, so that practice does not learn scenes by who else is there.

The violations that one search finds share most of their traffic: a network would know them by it, and not know the same
conflict among others.
"""

import numpy as np
from numpy.typing import NDArray

from roadmend.repair.adreft.rich_kernel import ENTER, FORECAST, GAP, MANNERS, PARTICIPANT, THEY_ENTER

_NEAR = 0.5  # of the gap's scale, 10 m: whoever is nearer is no bystander


def bystanders(tokens: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Rich tokens of participants that are far, come near in no forecast, and share no ground with the plan.

    Args:
        tokens: shape (..., c) as RichTokenizer gives them.

    Returns:
        Shape (...).
    """
    gaps = tokens[..., FORECAST : FORECAST + 2 * MANNERS : 2]
    apart = (tokens[..., ENTER] >= 1.0) & (tokens[..., THEY_ENTER] >= 1.0)
    return (tokens[..., PARTICIPANT] > 0.5) & (tokens[..., GAP] > _NEAR) & (gaps >= 1.0).all(axis=-1) & apart


def forget(
    tokens: NDArray[np.float32], mask: NDArray[np.bool_], share: float, generator: np.random.Generator
) -> NDArray[np.bool_]:
    """The mask without some bystanders.

    Args:
        tokens: shape (B, N, c).
        mask: true where there is a token, shape (B, N).
        share: of the bystanders to be left out, 0 .. 1.
        generator: decides which.
    """
    kept: NDArray[np.bool_] = mask & ~(bystanders(tokens) & (generator.random(mask.shape) < share))
    return kept
