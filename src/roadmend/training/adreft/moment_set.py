"""Moments of many cases in memory: soft labels, and weights by which they stand for ordinary driving."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.case_moments import CaseMoments
from roadmend.training.adreft.decision_set import DecisionSet

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class MomentSet(DecisionSet):
    """F moments; ``critical`` is the share of their futures that violate, ``judged`` a weight of mean 1."""

    averted: Floats  # share of the violations that a pulse of the action averts, 0 where unknown, shape (F, actions)
    averted_of: Floats  # violations behind that share, 0 where unknown, shape (F, actions)
    caused: Floats  # share of the harmless futures in which it leads to a collision, shape (F, actions)
    caused_of: Floats  # harmless futures behind that share, shape (F, actions)

    @classmethod
    def join(cls, moments: Sequence[CaseMoments], base_rate: float, exponent: float) -> Self:
        """All moments of some cases.

        A moment weighs the time of its drive that it stands for; all moments of cases that violate weigh so that
        these are ``base_rate`` of the cases. Nothing of that holds where all cases are of one kind.

        Args:
            moments: of the cases, at least one.
            base_rate: share of violations among ordinary drives, between 0 and 1.
            exponent: of the weight: at 1 as said, at 0 all moments weigh alike.
        """
        violations = sum(entry.violates for entry in moments)
        others = len(moments) - violations
        factor = base_rate / (1.0 - base_rate) * others / violations if violations and others else 1.0
        plain = np.concatenate([entry.span * (factor if entry.violates else 1.0) for entry in moments])
        weight = (plain / max(float(plain.mean()), 1e-12)) ** exponent
        tables = np.zeros((4, len(plain), len(ACTIONS)), dtype=np.float32)
        begin = 0
        for entry in moments:
            places = begin + entry.moment.astype(np.int64), entry.choice.astype(np.int64)
            found = entry.averted, entry.averted_of, entry.caused, entry.caused_of
            for table, values in zip(tables, found, strict=True):
                table[places] = np.nan_to_num(values.astype(np.float32))
            begin += len(entry)
        counts = np.concatenate([entry.counts for entry in moments]).astype(np.int64)
        return cls(
            np.concatenate([entry.tokens for entry in moments]),
            np.concatenate([[0], np.cumsum(counts)]),
            np.concatenate([entry.action for entry in moments]),
            np.concatenate([entry.danger for entry in moments]),
            (weight / weight.mean()).astype(np.float32),
            *tables,
        )
