"""What one case came to under one repair method, and the watcher that measures it."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Repair
from roadmend.core.tick import INTERVAL, Tick
from roadmend.world.runner import EpisodeSummary

WINDOW = 4  # ticks (0.2 s) over which accelerations and jerks are means


@dataclass(frozen=True, slots=True)
class CaseResult:
    """One case of a corpus under one method. Holds no time and no place: a rerun gives the same."""

    case: str
    family: str
    violation: bool  # whether the policy alone collides in it
    outcome: str  # an EventKind's name
    ticks: int
    duration: float  # [s] until the episode ended
    frames: int  # in which the command was replaced
    change: float  # sum of |policy's action - final action| over those frames, 0 .. 2 each
    min_distance: float | None  # [m] between the outlines, over the episode; none where the ego met nobody
    peak_deceleration: float  # [m/s2], see ``peaks``
    peak_jerk: float  # [m/s3], see ``peaks``
    digest: str  # of the trajectory

    @property
    def dose(self) -> float:
        """Seconds of full command: the change times the interval."""
        return self.change * INTERVAL

    @property
    def reached_goal(self) -> bool:
        """Whether the ego completed its route in time."""
        return self.outcome == EventKind.GOAL.name

    @property
    def collided(self) -> bool:
        """Whether the ego collided."""
        return self.outcome == EventKind.COLLISION.name

    @property
    def timed_out(self) -> bool:
        """Whether the time limit ended the episode: the ego stood, or was too slow."""
        return self.outcome == EventKind.TIMEOUT.name

    def dump(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)

    @classmethod
    def parse(cls, content: dict[str, Any]) -> Self:
        """From plain values.

        Raises:
            ValueError: they are no result.
        """
        try:
            return cls(**content)
        except TypeError as error:
            raise ValueError(str(error)) from None


class CaseWatcher:
    """Watches one episode (``world.runner.Watcher``) for what its summary does not hold."""

    def __init__(self) -> None:
        self._speeds: list[float] = []
        self._change = 0.0

    def __call__(self, tick: Tick, _decision: Decision, repair: Repair) -> None:
        """Take in one tick."""
        self._speeds.append(tick.scene.ego.speed)
        if repair.intervened:
            self._change += abs(repair.policy_action - repair.final_action)

    def result(self, case: str, family: str, summary: EpisodeSummary, *, violation: bool) -> CaseResult:
        """The result of the episode that was watched."""
        deceleration, jerk = peaks(self._speeds)
        distance = summary.min_distance if math.isfinite(summary.min_distance) else None
        return CaseResult(
            case,
            family,
            violation,
            summary.outcome.name,
            summary.ticks,
            summary.duration,
            summary.interventions,
            self._change,
            distance,
            deceleration,
            jerk,
            summary.digest,
        )


def peaks(speeds: Sequence[float]) -> tuple[float, float]:
    """The hardest deceleration [m/s2] and the largest jerk, of either sign [m/s3], of an episode.

    From the ego's speed at 20 Hz: the acceleration is the mean over WINDOW ticks, the jerk that of the acceleration
    over WINDOW ticks again, so that one tick's step of the brake does not count as an infinite jerk. The last tick is
    left out, since nothing is decided in it.

    Args:
        speeds: [m/s] at every tick.
    """
    window = WINDOW * INTERVAL
    values = np.asarray(speeds, dtype=np.float64)
    acceleration = (values[WINDOW:] - values[:-WINDOW]) / window
    jerk = (acceleration[WINDOW:] - acceleration[:-WINDOW]) / window
    hardest = max(0.0, -float(acceleration.min())) if len(acceleration) else 0.0
    return hardest, float(np.abs(jerk).max()) if len(jerk) else 0.0
