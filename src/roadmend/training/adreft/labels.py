"""Labels of frames: which are critical, and what to do in them. Schemes by name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.outcome import EventKind
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.closed_loop import EpisodeCase

NEAR = 1.0  # [m] delta_d: nearer than this to somebody is critical
BEFORE_COLLISION = 3.0  # [s] delta_t: so long before a collision everything is critical

_MILDEST, _STRONGEST = 0, len(ACTIONS) - 1


@dataclass(frozen=True, slots=True, eq=False)
class FrameLabels:
    """Labels of F frames, all of shape (F,)."""

    critical: NDArray[np.float32]  # what the monitor should say, 0 safe .. 1 critical
    action: NDArray[np.int64]  # what the adapter should choose, index into ACTIONS
    critical_weight: NDArray[np.float32]  # weight in the monitor's loss; 0: not learned from, not judged by
    action_weight: NDArray[np.float32]  # weight in the adapter's loss


class LabelScheme(Protocol):
    """Gives labels to the frames of cases."""

    def prepare(self, cases: Sequence[EpisodeCase], policy: str, cache: Path, mapper: Mapper) -> None:
        """Do beforehand, side by side, what takes long; called once before ``label``.

        Args:
            cases: all that will be labelled.
            policy: name of the policy that drives.
            cache: folder for what need not be done twice.
            mapper: runs a function on many questions.
        """

    def label(self, case: EpisodeCase, frames: CaseFrames) -> FrameLabels:
        """Labels of one case."""


@dataclass(frozen=True, slots=True)
class WeakLabels:
    """The paper's weak labels (ADReFT section 3.2.1, equations 5 and 6).

    A frame is critical where somebody is nearer than ``near``, or where the episode ends in a collision within
    ``before_collision``. The action is the strongest braking in critical frames and the mildest, 0.8, in the others.
    """

    near: float = NEAR  # [m] 0: the ablation without regulation
    before_collision: float = BEFORE_COLLISION  # [s]

    def prepare(self, cases: Sequence[EpisodeCase], policy: str, cache: Path, mapper: Mapper) -> None:
        """Nothing to do."""

    def label(self, case: EpisodeCase, frames: CaseFrames) -> FrameLabels:
        """Labels of one case; every frame weighs the same."""
        del case
        critical = frames.distance < self.near
        if frames.outcome == EventKind.COLLISION.name:
            critical |= frames.time > frames.end - self.before_collision
        action = np.where(critical, _STRONGEST, _MILDEST)
        weight = np.ones(len(frames), dtype=np.float32)
        return FrameLabels(critical.astype(np.float32), action.astype(np.int64), weight, weight)


SCHEMES: dict[str, Callable[[], LabelScheme]] = {
    "weak": WeakLabels,
    "weak_without_regulation": lambda: WeakLabels(near=0.0),
}


def make_scheme(name: str) -> LabelScheme:
    """A label scheme by name.

    Raises:
        InputError: there is no such scheme.
    """
    if name not in SCHEMES:
        raise InputError("label scheme", f"there is no {name!r}", f"choose one of: {', '.join(SCHEMES)}")
    return SCHEMES[name]()
