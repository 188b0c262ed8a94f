"""Rollouts of one case: what came of waiting and of acting at moments of a repaired drive. On disk as one .npz file."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import ArrayRecord

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class CaseRollouts(ArrayRecord):
    """F moments of one case with M tokens of c attributes in all, and T choices that were tried at them."""

    name: str  # of the case
    outcome: str  # of the repaired drive
    time: NDArray[np.float64]  # [s] of each moment, shape (F,)
    score: Floats  # the monitor's, shape (F,)
    action: Floats  # the policy's throttle - brake, shape (F,)
    collided: Floats  # share of the futures with a collision where the choice is to wait, shape (F,)
    counts: NDArray[np.int32]  # tokens of each moment, shape (F,)
    tokens: NDArray[np.float16]  # shape (M, c)
    moment: NDArray[np.int32]  # at which moment a choice was tried, shape (T,), as are all below
    choice: NDArray[np.int8]  # index into ACTIONS
    collided_then: Floats  # share of the same futures with a collision after the choice
    lost: Floats  # [s] by which the choice is later than waiting, mean over the futures in which neither collides

    def __len__(self) -> int:
        return len(self.time)
