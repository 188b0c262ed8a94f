"""Moments of one case with what came of them, over and over. On disk as one .npz file."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import ArrayRecord

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class CaseMoments(ArrayRecord):
    """F moments of one case with M tokens of c attributes in all, and T pulses that were tried at them."""

    name: str  # of the case
    violates: bool  # whether the policy's own drive ends in a violation
    futures: int  # of each moment
    time: NDArray[np.float64]  # [s] of each moment, shape (F,)
    span: Floats  # [s] of its drive that a moment stands for, shape (F,)
    action: Floats  # the policy's throttle - brake, shape (F,)
    danger: Floats  # share of the futures in which the policy left alone violates within the horizon, shape (F,)
    counts: NDArray[np.int32]  # tokens of each moment, shape (F,)
    tokens: NDArray[np.float16]  # shape (M, c); half precision is finer than what they measure
    moment: NDArray[np.int32]  # at which moment a pulse was tried, shape (T,), as are all below
    choice: NDArray[np.int8]  # index into ACTIONS
    averted: Floats  # share of the futures that violate alone in which the pulse leaves no collision; NaN of none
    caused: Floats  # share of the futures that do not collide alone in which the pulse leads to it; NaN of none
    averted_of: NDArray[np.int32]  # futures behind that share
    caused_of: NDArray[np.int32]  # and behind that one

    def __len__(self) -> int:
        return len(self.time)
