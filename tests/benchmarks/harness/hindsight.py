"""The hindsight bound: the brake profile of least dose that would have brought a violation to its goal.

It tells which violations braking can repair at all, and what an intervention costs at the least if one knows how the
episode goes on. The search is over re-simulations with the policy in the loop, so it is an upper bound on the true
least dose, found with a limited number of tries.

Traffic is sensitive: one tick of braking seconds before the impact often shifts everybody just so far that nobody
meets, and one tick earlier or later it does not. Two bounds are therefore kept apart. ``best`` is the least dose of a
profile that still reaches the goal when it is begun 0.1 s earlier and 0.1 s later; that is a repair. ``lucky`` is the
least dose of any profile that reaches the goal.
"""

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol, Self

from harness.pulse import DoseExceededError, Pulse, PulsePlayer
from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.interfaces import Policy
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Repair
from roadmend.core.scene import Scene
from roadmend.core.tick import INTERVAL, Tick
from roadmend.repair.actions import ACTIONS
from roadmend.training.collision import CollisionConfiguration, describe_collision
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario

BUDGET = 60  # re-simulations of a case
_LONG = 30.0  # [s] a budget of N tries also ends after N times this much simulation time
_SLACK = (-2, 2)  # [ticks] by which a repair may begin earlier or later and still be one
_HARD, _SOFT = -1.0, -0.4
_COARSE = (  # start before the impact [s], action, duration [s]; what repairs most often first
    *((start, _HARD, 1.0) for start in (3.5, 2.5, 4.5, 1.5)),
    *((start, _HARD, 2.0) for start in (2.5, 4.5, 1.5)),
    *((start, _SOFT, 2.0) for start in (3.5, 4.5, 2.5)),
    *((start, _HARD, 0.5) for start in (3.5, 1.5, 2.5, 4.5, 1.0, 0.5)),
    *((start, _HARD, 2.0) for start in (6.0, 8.0, 12.0, 16.0, 20.0)),  # before two block each other
    *((start, _HARD, 4.0) for start in (3.5, 6.0, 1.5, 10.0, 14.0, 20.0)),
    *((start, _HARD, 1.0) for start in (1.0, 6.0, 8.0, 12.0)),
    *((start, _SOFT, 1.0) for start in (3.5, 2.5, 4.5, 1.5, 1.0)),
    *((start, _HARD, 8.0) for start in (3.5, 6.0, 12.0, 20.0)),
)
_SHARES = (0.4, 0.6, 0.75, 0.88)  # of the least dose so far, aimed at one after the other
_SHIFTS = (0.5, -0.5, 1.0, -1.0, 0.25, -0.25)  # [s] by which a pulse is begun later


class Episode(Protocol):
    """What the bound wants to know of a case."""

    @property
    def name(self) -> str:
        """Name of the case."""

    @property
    def family(self) -> str:
        """Name of its family."""

    def scenario(self) -> Scenario:
        """What to run."""


@dataclass(frozen=True, slots=True)
class Profile:
    """A profile that reaches the goal, and what it costs."""

    pulse: Pulse
    before_impact: float  # [s] from its start to the impact without repair
    dose: float  # [s]
    intensity: float
    frames: int  # ticks whose command was replaced
    digest: str  # of the episode's trajectory

    @classmethod
    def parse(cls, content: dict[str, Any]) -> Self:
        """From plain values."""
        return cls(**{**content, "pulse": Pulse(**content["pulse"])})


@dataclass(frozen=True, slots=True)
class Bound:
    """What the search found for one case."""

    name: str
    family: str
    scenario: str  # digest
    outcome: str  # without any repair; an EventKind's name
    text: str  # the simulator's words for it
    impact: float  # [s] when it happened
    collision: CollisionConfiguration | None  # how it happened
    tries: int = 0  # re-simulations
    best: Profile | None = None
    lucky: Profile | None = None
    failures: dict[str, int] = field(default_factory=dict)  # how the tries ended that did not reach the goal

    @property
    def is_violation(self) -> bool:
        """Whether the case does collide without repair."""
        return self.outcome == EventKind.COLLISION.name

    @property
    def is_repairable(self) -> bool:
        """Whether a profile was found that reaches the goal, by luck or not."""
        return self.lucky is not None

    def dump(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)

    @classmethod
    def parse(cls, content: dict[str, Any]) -> Self:
        """From what ``dump`` gives.

        Raises:
            KeyError, TypeError, ValueError: it is not.
        """
        values = dict(content)
        values["collision"] = CollisionConfiguration(**values["collision"]) if values["collision"] else None
        for name in ("best", "lucky"):
            values[name] = Profile.parse(values[name]) if values[name] else None
        return cls(**values)


class PulseSearch:
    """Searches one case; every try is a run of the episode, cut off where it gets dearer than the best so far."""

    def __init__(self, case: Episode, policy: Policy, budget: int = BUDGET) -> None:
        """Prepare the search.

        Args:
            case: what to repair.
            policy: the policy in the loop.
            budget: re-simulations after which nothing new is begun.

        Raises:
            InputError: the case has no scenario.
        """
        self._case = case
        self._scenario = case.scenario()
        self._policy = policy
        self._budget = budget
        self._tries = 0
        self._simulated = 0.0  # [s]
        self._tried: set[Pulse] = set()
        self._failures: Counter[str] = Counter()
        self._best: Profile | None = None
        self._lucky: Profile | None = None

    def run(self) -> Bound:
        """Search until the budget is spent or nothing less is found.

        Raises:
            InputError: the scenario cannot be run.
            SimulationError: SUMO failed.
        """
        scene: Scene | None = None

        def watch(tick: Tick, _decision: Decision, _repair: Repair) -> None:
            nonlocal scene
            scene = tick.scene

        player = PulsePlayer()
        before = run_episode(self._scenario, self._policy, player, watch)
        self._actions = list(player.actions)
        self._impact = before.ticks
        collision = describe_collision(scene, before.final) if scene is not None else None
        if before.outcome == EventKind.COLLISION:
            self._look_around()
            self._refine()
        return Bound(
            self._case.name,
            self._case.family,
            self._scenario.digest,
            before.outcome.name,
            before.text,
            before.duration,
            collision,
            self._tries,
            self._best,
            self._lucky,
            dict(sorted(self._failures.items())),
        )

    def _look_around(self) -> None:
        for start, action, duration in _COARSE:
            pulse = Pulse(max(0, self._impact - _ticks(start)), _ticks(duration), action)
            if self._is_spent or self._try(pulse):
                return

    def _refine(self) -> None:
        """Aim at ever larger shares of the least dose; after a success begin anew with the smallest share."""
        level = 0
        while self._best is not None and level < len(_SHARES) and not self._is_spent:
            level = 0 if self._aim(self._best, _SHARES[level]) else level + 1

    def _aim(self, best: Profile, share: float) -> bool:
        """Try pulses of about ``share`` of the dose of ``best``; whether one of them is a repair."""
        for begin, action in self._neighbours(best.pulse):
            pulse = self._pulse_of(begin, action, share * best.dose)
            if pulse is not None and self._try(pulse):
                return True
            if self._is_spent:
                return False
        return False

    def _neighbours(self, pulse: Pulse) -> Iterator[tuple[int, float]]:
        """Begin [tick] and action of pulses like ``pulse``: itself, begun at other times, milder, stronger."""
        place = ACTIONS.index(pulse.action)
        yield pulse.begin, pulse.action
        for shift in _SHIFTS[:4]:
            yield pulse.begin + _ticks(shift), pulse.action
        for step in (-2, 2, -1):
            if 0 <= place + step < len(ACTIONS):
                yield pulse.begin, ACTIONS[place + step]
        for shift in _SHIFTS[4:]:
            yield pulse.begin + _ticks(shift), pulse.action

    def _pulse_of(self, begin: int, action: float, dose: float) -> Pulse | None:
        """The longest pulse that would cost at most ``dose`` [s] on the actions of the episode without repair."""
        spent, tick = 0.0, begin
        if not 0 <= begin < self._impact:
            return None
        while tick < begin + _ticks(10.0):
            asked = self._actions[min(tick, self._impact - 1)]
            spent += max(0.0, asked - action) * INTERVAL
            if spent > dose:
                break
            tick += 1
        return Pulse(begin, tick - begin, action) if tick > begin else None

    @property
    def _is_spent(self) -> bool:
        return self._tries >= self._budget or self._simulated >= self._budget * _LONG

    def _try(self, pulse: Pulse) -> bool:
        """Run the case with a pulse; whether it is a repair with less dose than the best."""
        if pulse in self._tried:
            return False
        self._tried.add(pulse)
        limit = self._best.dose if self._best is not None else math.inf
        summary = self._run(pulse, limit)
        if summary is None or not 0.0 < summary.dose < limit:
            return False
        before = (self._impact - pulse.begin) * INTERVAL
        found = Profile(pulse, round(before, 9), summary.dose, summary.intensity, summary.interventions, summary.digest)
        if self._lucky is None or found.dose < self._lucky.dose:
            self._lucky = found
        for shift in _SLACK:
            shifted = Pulse(max(0, pulse.begin + shift), pulse.ticks, pulse.action)
            if self._run(shifted, math.inf) is None:
                return False
        self._best = found
        return True

    def _run(self, pulse: Pulse, limit: float) -> EpisodeResult | None:
        """The episode with a pulse, where it reaches the goal below ``limit`` [s]."""
        self._tries += 1
        try:
            summary = run_episode(self._scenario, self._policy, PulsePlayer((pulse,), limit))
        except DoseExceededError:
            self._simulated += pulse.end * INTERVAL
            self._failures["DEARER"] += 1
            return None
        self._simulated += summary.duration
        if summary.outcome == EventKind.GOAL:
            return summary
        self._failures[summary.outcome.name] += 1
        return None


def _ticks(time: float) -> int:
    return round(time / INTERVAL)
