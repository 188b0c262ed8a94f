"""What the network says of a crash: which of its outputs stands for which value of the scenario language."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core import portable_math
from roadmend.safe.claims import WayRelation
from roadmend.safe.dsl import KM_PER_MILE, Action, Compass, DslModel, Position, RoadType, Side, Time, Weather

SEATS = 8  # vehicles that are told apart
HEADINGS = (Position.S2N, Position.W2E, Position.N2S, Position.E2W)  # clockwise, as STEMS
RAMP = (Position.MAIN_ROAD, Position.ON_RAMP)  # instead of a heading, where roads merge
STEMS = (Compass.NORTH, Compass.EAST, Compass.SOUTH, Compass.WEST)
RELATIONS = (WayRelation.SAME, WayRelation.FROM_LEFT, WayRelation.OPPOSITE, WayRelation.FROM_RIGHT)
"""Of a second heading to a first, by how many quarter turns it lies further round, clockwise."""

ACTIONS = tuple(Action)
MODELS = tuple(DslModel)
ROADS = tuple(RoadType)
LANES = (None, *range(1, 9))
TIMES = (None, *Time)
WEATHERS = (None, *Weather)
LIMITS = (None, *sorted({*range(5, 90, 5), *(round(limit / KM_PER_MILE) for limit in range(10, 140, 10))}))
"""Posted limits [mph] of both systems; None, here and above, where the text tells nothing of it."""

TOUCHED = (None, *Side)  # where the second of two vehicles was struck by the first; None where it was not


@dataclass(frozen=True, slots=True)
class ReaderQuestion:
    """One thing that the network is asked.

    Attributes:
        name: of the question.
        field: of the scenario language, that of a vehicle or a collision from there on, which the answer is a value of.
        values: possible answers, in the order of the outputs.
        weight: of its loss in training.
    """

    name: str
    field: str
    values: tuple[Any, ...]
    weight: float


OF_VEHICLE = (
    ReaderQuestion("heading", "initial_position", HEADINGS, 1.0),
    ReaderQuestion("action", "action", ACTIONS, 0.5),
    ReaderQuestion("model", "model", MODELS, 0.3),
    ReaderQuestion("speed_limit", "speed_limit_mph", LIMITS, 0.3),
    ReaderQuestion("ramp", "initial_position", RAMP, 0.3),
)
RELATION = ReaderQuestion("relation", "", RELATIONS, 1.0)  # of two fields
OF_PAIR = (
    RELATION,
    ReaderQuestion("struck_side", "struck_side", TOUCHED, 0.5),
    ReaderQuestion("striking_side", "striking_side", TOUCHED, 0.3),
)
OF_TEXT = (
    ReaderQuestion("road_type", "road_type", ROADS, 0.5),
    ReaderQuestion("stem", "stem_direction", STEMS, 0.5),
    ReaderQuestion("lanes", "num_lanes", LANES, 0.3),
    ReaderQuestion("time", "env.time", TIMES, 0.2),
    ReaderQuestion("weather", "env.weather", WEATHERS, 0.2),
)
OF_PIECE = (ReaderQuestion("party", "", (None, *range(SEATS)), 1.0),)
"""Which of those who took part a piece of an unmarked text names, in the order in which they are first named; None: no one."""

CLAIMED = (*OF_VEHICLE, *OF_TEXT, RELATION)
"""What claims are made of; of contacts none are."""


def width_of(questions: tuple[ReaderQuestion, ...]) -> int:
    """Outputs that a group of questions takes."""
    return sum(len(question.values) for question in questions)


def shares_of(logits: NDArray[np.float32], questions: tuple[ReaderQuestion, ...]) -> dict[str, NDArray[np.float64]]:
    """Probabilities (..., answers) of each question of a group, from its logits (..., outputs)."""
    found, at = {}, 0
    for question in questions:
        own = logits[..., at : at + len(question.values)].astype(np.float64)
        own = portable_math.exp(own - own.max(axis=-1, keepdims=True))
        found[question.name] = own / own.sum(axis=-1, keepdims=True)
        at += len(question.values)
    return found
