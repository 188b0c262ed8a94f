"""What an episode came to: the one record of it, and what takes it in tick by tick."""

import hashlib
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from pydantic import ConfigDict, TypeAdapter

from roadmend.core.command import Command
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Interventions, Repair
from roadmend.core.scene import EgoState
from roadmend.core.spell import Spell, SpellBuilder
from roadmend.core.tick import INTERVAL, Tick

WINDOW = 4  # ticks (0.2 s) over which accelerations and jerks are means


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    """What an episode came to. Holds no time of the wall and no place: driven again, it is the same."""

    __pydantic_config__ = ConfigDict(extra="forbid")

    scenario: str
    policy: str  # name; empty where it is not known
    method: str  # of repair; empty where it is not known
    final: Event
    events: tuple[Event, ...]  # all, the final one too
    ticks: int
    duration: float  # [s] of simulation time
    min_distance: float | None  # [m] between the outlines of the ego and the nearest other; none where nobody was met
    interventions: int  # ticks whose command was replaced
    change: float  # sum of |policy's action - final action| over those ticks, 0 .. 2 each
    peak_deceleration: float  # [m/s2], see ``peaks``
    peak_jerk: float  # [m/s3], see ``peaks``
    mean_jerk: float  # [m/s3] mean size, see ``peaks``
    distance: float  # [m] that the ego drove
    spells: tuple[Spell, ...]  # of intervention
    digest: str  # SHA-256 of the trajectory, see ``TrajectoryDigest``
    is_finite: bool  # whether every pose and command was a finite number

    @property
    def outcome(self) -> EventKind:
        """How it ended."""
        return self.final.kind

    @property
    def text(self) -> str:
        """How it ended, in a sentence for people."""
        return self.final.text

    @property
    def intensity(self) -> float:
        """Mean change of a replaced command, 0 .. 2."""
        return Interventions(self.interventions, self.change).intensity

    @property
    def dose(self) -> float:
        """Seconds of full command by which it was changed."""
        return Interventions(self.interventions, self.change).dose

    @property
    def held_back(self) -> int:
        """Lane changes that the policy asked for and the merger held back."""
        return sum(spell.held_back for spell in self.spells)

    @property
    def reached_goal(self) -> bool:
        """Whether the ego completed its route in time."""
        return self.outcome is EventKind.GOAL

    @property
    def collided(self) -> bool:
        """Whether the ego collided."""
        return self.outcome is EventKind.COLLISION

    @property
    def timed_out(self) -> bool:
        """Whether the time limit ended the episode: the ego stood, or was too slow."""
        return self.outcome is EventKind.TIMEOUT

    def figures(self) -> dict[str, Any]:
        """The outcome and the figures by name, as commands show them; ``dump`` is what can be read back."""
        return {
            "scenario": self.scenario,
            "policy": self.policy,
            "method": self.method,
            "outcome": self.outcome.name,
            "text": self.text,
            "duration": self.duration,
            "ticks": self.ticks,
            "min_distance": self.min_distance,
            "interventions": self.interventions,
            "intensity": self.intensity,
            "dose": self.dose,
            "held_back": self.held_back,
            "peak_deceleration": self.peak_deceleration,
            "peak_jerk": self.peak_jerk,
            "digest": self.digest,
        }

    def dump(self) -> dict[str, Any]:
        """As plain values."""
        content: dict[str, Any] = _PLAIN.dump_python(self, mode="json")
        return content

    @classmethod
    def parse(cls, content: dict[str, Any]) -> Self:
        """From plain values.

        Raises:
            ValueError: they are no result.
        """
        result = _PLAIN.validate_python(content)
        assert isinstance(result, cls)
        return result


_PLAIN = TypeAdapter(EpisodeResult)


class TrajectoryDigest:
    """SHA-256 over what the ego did and what it was told, tick by tick: equal digests mean bit-identical runs."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, time: float, ego: EgoState, command: Command) -> None:
        """Add one tick."""
        values = (time, ego.x, ego.y, ego.yaw, ego.speed, command.throttle, command.brake)
        self._hash.update(struct.pack("<7d", *values))

    @property
    def hexadecimal(self) -> str:
        """The digest so far."""
        return self._hash.hexdigest()


class ResultBuilder:
    """Takes in an episode as it is driven or read from a bag, and tells what it came to.

    Args:
        scenario: its name.
        policy: who drives; empty where that is not known.
        method: of repair; empty where that is not known.
    """

    def __init__(self, scenario: str, policy: str = "", method: str = "") -> None:
        self.scenario = scenario
        self.final: Event | None = None
        self.ticks = 0
        self.duration = 0.0  # [s] so far
        self.interventions = Interventions()
        self._names = (scenario, policy, method)
        self._min_distance = math.inf
        self._events: list[Event] = []
        self._speeds: list[float] = []
        self._digest = TrajectoryDigest()
        self._is_finite = True
        self._distance = 0.0
        self._place: tuple[float, float] | None = None
        self._spells = SpellBuilder()

    def see(self, tick: Tick) -> None:
        """Take in what there is to see at a tick."""
        ego = tick.scene.ego
        self._is_finite = self._is_finite and math.isfinite(ego.x + ego.y + ego.yaw + ego.speed)
        self.ticks, self.duration = tick.number, tick.scene.time
        if self._place is not None:
            self._distance += math.dist(self._place, (ego.x, ego.y))
        self._place = ego.x, ego.y
        self._min_distance = min(self._min_distance, tick.min_distance)
        for event in tick.events:
            self.note(event)

    def note(self, event: Event) -> None:
        """Take in an event that comes beside the ticks."""
        self._events.append(event)
        if event.kind.is_final:
            self.final = event

    def repair(self, repair: Repair) -> None:
        """Take in what the repair method did at a tick."""
        self.interventions.add(repair)
        self._spells.add(self.duration, repair)

    def command(self, tick: Tick, command: Command) -> None:
        """Take in what the ego was told at a tick; at the final one it is told nothing."""
        self._digest.add(tick.scene.time, tick.scene.ego, command)
        if tick.final is None:
            self._is_finite = self._is_finite and math.isfinite(command.action)
            self._speeds.append(tick.scene.ego.speed)

    def result(self) -> EpisodeResult:
        """What the episode came to, after its final event."""
        assert self.final is not None
        return EpisodeResult(
            *self._names,
            self.final,
            tuple(self._events),
            self.ticks,
            self.duration,
            self._min_distance if math.isfinite(self._min_distance) else None,
            self.interventions.ticks,
            self.interventions.change,
            *peaks(self._speeds),
            self._distance,
            self._spells.spells,
            self._digest.hexadecimal,
            self._is_finite,
        )


def peaks(speeds: Sequence[float]) -> tuple[float, float, float]:
    """The hardest deceleration [m/s2], and the largest and the mean jerk, of either sign [m/s3], of an episode.

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
    size = np.abs(jerk)
    return (hardest, float(size.max()), float(size.mean())) if len(jerk) else (hardest, 0.0, 0.0)
