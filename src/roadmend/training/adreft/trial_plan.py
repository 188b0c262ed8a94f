"""Which interventions a trial plays, drawn at random from a seed."""

import random
from collections.abc import Iterator
from dataclasses import dataclass

from roadmend.core.outcome import EventKind
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.weighing import MILDEST

_PAUSE = 2.0  # [s] longest pause between two interventions of a trial


@dataclass(frozen=True, slots=True)
class InterventionPattern:
    """How the interventions of a trial are drawn."""

    latest: float  # [s] before the collision, between which and ``earliest`` the first intervention begins
    earliest: float  # [s]
    shortest: float  # [s] of an action held
    longest: float  # [s]
    usual: float  # [s] mean of what is held beyond the shortest
    numbers: tuple[int, ...]  # of interventions in a trial, each as likely
    mildest: int  # index into ACTIONS, between which and ``strongest`` an action is drawn
    strongest: int


ABRUPT = InterventionPattern(0.3, 6.0, 0.2, 4.0, 0.8, (1, 1, 2, 3), MILDEST, len(ACTIONS) - 1)
# To be careful for a while, before anything has happened: what is short and mild changes nothing.
GENTLE = InterventionPattern(2.0, 14.0, 2.0, 10.0, 3.0, (1, 1, 2), 2, 7)


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
    gentle_per_violation: int = 0  # long and mild trials besides; what is driven blinded gets none
    gentle_per_success: int = 0

    def holds(
        self, name: str, number: int, end: float, *, collides: bool, manner: InterventionPattern = ABRUPT
    ) -> list[Hold]:
        """The interventions of one trial, drawn from the seed, the name and the trial's number.

        Args:
            name: of what is driven.
            number: of the trial, from 1.
            end: when the policy alone collides or ends the case [s].
            collides: which of the two.
            manner: how they are drawn.
        """
        chance = random.Random(f"{self.seed}:{self.guide}{name}:{number}")
        # Index 0 hardly ever intervenes: where a guide drives along, that is a choice too.
        mildest = 0 if self.guide else manner.mildest
        if collides:
            begin = max(0.0, end - chance.uniform(manner.latest, manner.earliest))
        else:
            begin = chance.uniform(0.0, max(0.0, end - 1.0))
        planned = []
        for _ in range(chance.choice(manner.numbers)):
            duration = min(manner.longest, manner.shortest + chance.expovariate(1.0 / manner.usual))
            planned.append(Hold(begin, begin + duration, chance.randrange(mildest, manner.strongest + 1)))
            begin += duration + chance.choice((0.0, 0.0, chance.uniform(0.0, _PAUSE)))
        return planned

    def trials(self, name: str, outcome: EventKind, end: float) -> Iterator[list[Hold]]:
        """The interventions of every abrupt trial of what came to ``outcome`` at ``end`` [s] without holds."""
        collides = outcome == EventKind.COLLISION
        for number in range(1, 1 + (self.per_success if outcome == EventKind.GOAL else self.per_violation)):
            yield self.holds(name, number, end, collides=collides)

    def gentle_trials(self, name: str, outcome: EventKind, end: float) -> Iterator[list[Hold]]:
        """As ``trials``, of every gentle one."""
        collides = outcome == EventKind.COLLISION
        count = self.gentle_per_success if outcome == EventKind.GOAL else self.gentle_per_violation
        for number in range(1, 1 + count):
            yield self.holds(f"gentle:{name}", number, end, collides=collides, manner=GENTLE)
