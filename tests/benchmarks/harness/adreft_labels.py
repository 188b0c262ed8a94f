"""The weak labels of the training, for the benchmark of the monitors: evaluation and training do not know each other."""

import numpy as np
from numpy.typing import NDArray

from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.adreft.labels import WeakLabels
from roadmend.world.corpus import Case


def weak_labels(
    case: Case, time: NDArray[np.float64], distance: NDArray[np.float64], end: float, outcome: str
) -> NDArray[np.bool_]:
    """Whether each frame of an episode is critical (``evaluation.case_jobs.Labels``)."""
    frames = CaseFrames(
        name=case.name,
        family=case.family,
        outcome=outcome,
        end=end,
        time=time,
        distance=distance,
        action=np.zeros(len(time), dtype=np.float32),
        counts=np.zeros(len(time), dtype=np.int32),
        tokens=np.zeros((0, 0), dtype=np.float32),
    )
    critical: NDArray[np.bool_] = WeakLabels().label(case, frames).critical > 0.5
    return critical
