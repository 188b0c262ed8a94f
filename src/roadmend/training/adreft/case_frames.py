"""Frames of one case: what the model would have seen while the policy drove alone. On disk as one .npz file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import load_record, save_record


@dataclass(frozen=True, slots=True, eq=False)
class CaseFrames:
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

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all.

        Raises:
            InputError: the place cannot be written.
        """
        save_record(path, self)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file.

        Raises:
            OSError: there is no such file.
            ValueError: it is damaged.
        """
        return load_record(path, cls)
