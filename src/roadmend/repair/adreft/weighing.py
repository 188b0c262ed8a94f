"""From what an adapter foresees to what every action is worth.

The paper's adapter gives the values themselves (ADReFT section 3.1.3). A value is made of two things: how likely a
collision is with and without the action, which must be learned, and what the action costs, which is known. Learned as
one number, the difference that a second of careful braking makes drowns in the error of the estimate; learned apart, a
cost has no error, and the prices can change without a new training.
"""

import math

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roadmend.core import portable_math
from roadmend.core.parameters import Parameters
from roadmend.repair.actions import ACTIONS

Floats = NDArray[np.float32]

OUTPUTS = 1 + 2 * len(ACTIONS)
DANGER = 0  # logit: the policy alone collides, discounted by the time until then
AVERTED = slice(1, 1 + len(ACTIONS))  # logits: of a collision to come, the action averts it
CAUSED = slice(1 + len(ACTIONS), OUTPUTS)  # logits: where there would be no collision, the action leads to one

_ACTIONS = np.array(ACTIONS)
MILDEST = 1  # index of the first action that trials hold: the one before hardly ever intervenes; nothing is known of it


class Weighing(Parameters):
    """The prices; saved in a model's header."""

    collision: float = Field(10.0, gt=0.0, le=1000.0, description="price of a collision")
    strength: float = Field(0.4, ge=0.0, le=1000.0, description="price of an intervention of strength 1")
    exponent: float = Field(2.0, ge=1.0, le=4.0, description="of its strength; above 1 gentle is cheap")
    any: float = Field(0.1, ge=0.0, le=1000.0, description="price of an intervention, however gentle")
    gain: float = Field(
        0.0,
        ge=0.0,
        le=1000.0,
        description="an intervention that is worth more than this is due, whatever the monitor says; 0: never",
    )
    rear: float = Field(
        0.0,
        ge=0.0,
        le=60.0,
        description="but not while somebody would be at the ego's rear within this time [s]; 0: whoever is there",
    )


def weigh(foreseen: Floats, asked: float, prices: Weighing) -> Floats:
    """Value of every action where the policy asks for ``asked``, shape (actions,).

    Actions that do not brake harder than the policy change nothing: they are worth what the policy alone is worth, and
    so is the one that no trial has held.

    Args:
        foreseen: what the adapter gives, logits of shape (OUTPUTS,).
        asked: the policy's throttle - brake.
        prices: of collisions and interventions.
    """
    chances = 1.0 / (1.0 + portable_math.exp(-np.clip(foreseen.astype(np.float64), -60.0, 60.0)))
    if not math.isfinite(float(foreseen.sum())):
        chances[:] = np.nan
    danger = chances[DANGER]
    strength = _strengths(asked)
    with_it = danger * (1.0 - chances[AVERTED]) + (1.0 - danger) * chances[CAUSED]
    cost = prices.strength * portable_math.power(strength, prices.exponent) + prices.any
    values: NDArray[np.float64] = np.where(
        strength > 0.0, -prices.collision * with_it - cost, -prices.collision * danger
    )
    return values.astype(np.float32)


def gain_of(values: Floats, asked: float, chosen: int | None = None) -> float:
    """How much more an action is worth than leaving the policy alone.

    Args:
        values: of every action, as ``weigh`` gives them.
        asked: the policy's throttle - brake.
        chosen: index of the action; None for the best one, which alone cannot be worth less.
    """
    idle = _strengths(asked) == 0.0
    value = values.max() if chosen is None else values[chosen]
    return float(value - values[idle].max())


def _strengths(asked: float) -> NDArray[np.float64]:
    """How much harder than ``asked`` every action brakes, shape (actions,); 0 where it stays with the policy."""
    strength = np.maximum(asked - _ACTIONS, 0.0)
    strength[:MILDEST] = 0.0
    return strength
