"""What trials tell of collisions with and without an intervention.

A trial is the same episode as the policy's own drive up to its first intervention. So of that moment both is known:
what came without it, and what came with it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.outcome import EventKind
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.trials import PASS, CaseTrials

Floats = NDArray[np.float32]

_ACTIONS = np.array(ACTIONS, dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Counterfactuals:
    """Labels of F decisions, in the order of the ``TrialSet`` of the same trials; NaN where nothing is known."""

    danger: Floats  # from here on the policy was alone: 0, or gamma to the number of decisions until its collision
    tried: NDArray[np.int64]  # index into ACTIONS of what was held, meaningful where one of the next two is known
    averted: Floats  # the policy alone collides: 1 where with the intervention it reached its goal, else 0
    caused: Floats  # the policy alone does not: 1 where with the intervention it collided, else 0

    @classmethod
    def join(cls, trials: Sequence[CaseTrials], section: PracticeSection) -> Self:
        """Labels of some cases.

        Args:
            trials: the cases; the trials of a drive follow the drive without holds.
            section: gamma, and how long after its begin an intervention speaks for the moment of its begin.
        """
        parts = [_labels(entry, section) for entry in trials]
        return cls(*(np.concatenate([part[column] for part in parts]) for column in range(4)))

    @property
    def alone(self) -> NDArray[np.int64]:
        """Indices of the decisions from which on the policy was alone."""
        return np.flatnonzero(~np.isnan(self.danger))

    @property
    def interfered(self) -> NDArray[np.int64]:
        """Indices of the decisions that tell of an intervention."""
        return np.flatnonzero(~(np.isnan(self.averted) & np.isnan(self.caused)))


def _labels(trials: CaseTrials, section: PracticeSection) -> tuple[Floats, NDArray[np.int64], Floats, Floats]:
    count = len(trials.time)
    danger, averted, caused = (np.full(count, np.nan, dtype=np.float32) for _ in range(3))
    tried = np.zeros(count, dtype=np.int64)
    begin = 0
    collides: bool | None = None
    for outcome, length in zip(trials.outcomes, trials.lengths, strict=True):
        end = begin + int(length)
        choice = trials.choice[begin:end]
        held = np.flatnonzero(choice != PASS)
        first_alone = begin + (int(held[-1]) + 1 if len(held) else 0)
        rest = np.arange(first_alone, end)
        crashed = outcome == int(EventKind.COLLISION)
        danger[rest] = section.gamma ** (end - 1 - rest) if crashed else 0.0
        if not len(held):
            collides = bool(crashed)
        braking = begin + np.flatnonzero((choice != PASS) & (_ACTIONS[choice] < trials.action[begin:end]))
        if len(held) and len(braking) and collides is not None:
            same = trials.choice[braking] == trials.choice[braking[0]]
            early = trials.time[braking] < trials.time[braking[0]] + section.lasting
            told = braking[same & early]
            tried[told] = trials.choice[told]
            if collides:
                averted[told] = float(outcome == int(EventKind.GOAL))
            else:
                caused[told] = float(crashed)
        begin = end
    return danger, tried, averted, caused
