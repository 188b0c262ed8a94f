"""Which interventions a trial plays, drawn at random from a seed."""

import hashlib
import json
import random
from collections.abc import Iterator
from dataclasses import asdict, dataclass

from roadmend.core.outcome import EventKind
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.closed_loop import EpisodeCase

_LAYOUT = 4  # of a file with trials; grows with every change
_LATEST, _EARLIEST = 0.3, 6.0  # [s] before the collision, between which the first intervention of a trial begins
_SHORTEST, _LONGEST = 0.2, 4.0  # [s] of an action held
_USUAL = 0.8  # [s] mean of what is held beyond the shortest
_PAUSE = 2.0  # [s] longest pause between two interventions of a trial
_NUMBERS = (1, 1, 2, 3)  # of interventions in a trial, each as likely


@dataclass(frozen=True, slots=True)
class Hold:
    """An action that is held for a while."""

    begin: float  # [s] simulation time
    end: float  # [s]
    action: int  # index into ACTIONS


@dataclass(frozen=True, slots=True)
class TrialPlan:
    """How many trials a case gets. The first episode of a case always runs without holds."""

    per_violation: int
    per_success: int
    blinded: int  # times that what does not collide is driven blinded; where that collides, per_violation trials more
    interval: int  # ticks between two decisions
    seed: int
    guide: str = ""  # digest of the model that drives along

    def key(self, case: EpisodeCase, recipe: Recipe) -> str:
        """Name for a case's trials: cases or plans that differ have different ones."""
        text = json.dumps([_LAYOUT, recipe.key(case), *asdict(self).values()])
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def holds(self, name: str, number: int, end: float, *, collides: bool) -> list[Hold]:
        """The interventions of one trial, drawn from the seed, the name and the trial's number.

        Args:
            name: of what is driven.
            number: of the trial, from 1.
            end: when the policy alone collides or ends the case [s].
            collides: which of the two.
        """
        chance = random.Random(f"{self.seed}:{self.guide}{name}:{number}")
        if collides:
            begin = max(0.0, end - chance.uniform(_LATEST, _EARLIEST))
        else:
            begin = chance.uniform(0.0, max(0.0, end - 1.0))
        planned = []
        for _ in range(chance.choice(_NUMBERS)):
            duration = min(_LONGEST, _SHORTEST + chance.expovariate(1.0 / _USUAL))
            # Index 0 hardly ever intervenes: where a guide drives along, that is a choice too.
            planned.append(Hold(begin, begin + duration, chance.randrange(0 if self.guide else 1, len(ACTIONS))))
            begin += duration + chance.choice((0.0, 0.0, chance.uniform(0.0, _PAUSE)))
        return planned

    def trials(self, name: str, outcome: EventKind, end: float) -> Iterator[list[Hold]]:
        """The interventions of every trial of what came to ``outcome`` at ``end`` [s] without holds."""
        collides = outcome == EventKind.COLLISION
        for number in range(1, 1 + (self.per_success if outcome == EventKind.GOAL else self.per_violation)):
            yield self.holds(name, number, end, collides=collides)
