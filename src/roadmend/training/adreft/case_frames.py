"""Frames of one case: what the model would have seen while the policy drove alone. On disk as one .npz file."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import ArrayRecord


@dataclass(frozen=True, slots=True, eq=False)
class CaseFrames(ArrayRecord):
    """F frames of one case with M tokens of c attributes in all."""

    name: str  # of the case
    family: str
    outcome: str  # an EventKind's name
    end: float  # [s] simulation time of the episode's end
    time: NDArray[np.float64]  # [s] shape (F,)
    action: NDArray[np.float32]  # the policy's throttle - brake, shape (F,)
    distance: NDArray[
        np.float64
    ]  # [m] from the ego's outline to the nearest other, inf where there is none, shape (F,)
    counts: NDArray[np.int32]  # tokens of each frame, shape (F,)
    tokens: NDArray[np.float32]  # of all frames in their order, shape (M, c)

    def __len__(self) -> int:
        return len(self.time)
