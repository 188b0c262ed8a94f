"""Trials of many cases in memory: what a decision came to, and the batches that are drawn."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.outcome import EventKind
from roadmend.core.tick import INTERVAL
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.decision_set import DecisionSet
from roadmend.training.adreft.trials import PASS, CaseTrials

Floats = NDArray[np.float32]

_ACTIONS = np.array(ACTIONS, dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class TrialSet(DecisionSet):
    """F decisions of many episodes."""

    # Shapes are (F,), but for ``alike``. ``critical`` is the weak label of what was really driven; ``judged`` is 1
    # where that speaks of the policy, 0 where an intervention may have made it harmless.
    reward: Floats  # discounted sum over the next ``steps`` decisions
    discount: Floats  # of the value of ``following``
    following: NDArray[np.int64]  # the decision ``steps`` later, -1 where the episode has ended by then
    total: Floats  # discounted sum to the end of the episode
    alike: NDArray[np.bool_]  # the actions that would have done the same, perhaps none, shape (F, actions)

    @classmethod
    def join(cls, trials: Sequence[CaseTrials], section: PracticeSection) -> Self:
        """All decisions of some cases.

        The reward of a decision is minus the price of its dose and of its time; the last one of an episode also bears
        the price of a collision or of a goal not reached. Actions above the policy's own do nothing, so they are alike.
        """
        parts = [_returns(entry, section) for entry in trials]
        starts = np.concatenate([[0], np.cumsum([len(entry.time) for entry in trials])])[:-1]
        following = [
            np.where(part.following >= 0, part.following + start, -1) for part, start in zip(parts, starts, strict=True)
        ]
        action = np.concatenate([entry.action for entry in trials])
        choice = np.concatenate([entry.choice for entry in trials]).astype(np.int64)
        alike = np.zeros((len(action), len(ACTIONS)), dtype=np.bool_)
        held = np.flatnonzero(choice != PASS)
        alike[held, choice[held]] = True
        idle = (choice == PASS) | (_ACTIONS[choice] >= action)
        alike |= idle[:, None] & (_ACTIONS[None, :] >= action[:, None])
        counts = np.concatenate([entry.counts for entry in trials]).astype(np.int64)
        return cls(
            np.concatenate([entry.tokens for entry in trials]),
            np.concatenate([[0], np.cumsum(counts)]),
            action,
            np.concatenate([part.critical for part in parts]),
            np.concatenate([part.judged for part in parts]),
            np.concatenate([part.reward for part in parts]),
            np.concatenate([part.discount for part in parts]),
            np.concatenate(following),
            np.concatenate([part.total for part in parts]),
            alike,
        )

    @property
    def digest(self) -> str:
        """SHA-256 over all that is learned from, hexadecimal."""
        return self.digest_of("discount", "following")


@dataclass(frozen=True, slots=True, eq=False)
class _Returns:
    """The decisions of one case; shapes (F,)."""

    critical: Floats
    judged: Floats
    reward: Floats
    discount: Floats
    following: NDArray[np.int64]  # within the case
    total: Floats


def _returns(trials: CaseTrials, section: PracticeSection) -> _Returns:
    count = len(trials.time)
    strength = trials.dose.astype(np.float64) / (section.interval * INTERVAL)
    reward = -section.dose * trials.dose * strength ** (section.dose_exponent - 1.0) - section.time
    critical = trials.distance < section.near
    judged = np.ones(count, dtype=np.bool_)
    following = np.full(count, -1, dtype=np.int64)
    summed, discount, total = np.zeros(count), np.zeros(count), np.zeros(count)
    begin = 0
    for episode, length in enumerate(trials.lengths):
        end = begin + int(length)
        if trials.outcomes[episode] == int(EventKind.COLLISION):
            reward[end - 1] += section.violation
            critical[begin:end] |= trials.time[begin:end] > trials.ends[episode] - section.before_collision
        elif trials.outcomes[episode] != int(EventKind.GOAL):
            reward[end - 1] += section.timeout
        after, changed = 0.0, np.inf  # when the ego was last interfered with, seen from the end [s]
        for index in range(end - 1, begin - 1, -1):
            if trials.dose[index] > 0.0:
                changed = trials.time[index]
            judged[index] = critical[index] or changed > trials.time[index] + section.before_collision
            after = reward[index] + section.gamma * after
            total[index] = after
            last = min(index + section.steps, end)
            powers = section.gamma ** np.arange(last - index)
            summed[index] = float(powers @ reward[index:last])
            if last < end:
                following[index], discount[index] = last, section.gamma ** (last - index)
        begin = end
    plain = [array.astype(np.float32) for array in (critical, judged, summed, discount, total)]
    return _Returns(plain[0], plain[1], plain[2], plain[3], following, plain[4])
