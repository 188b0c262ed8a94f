"""Drives a recorded run again until a chosen tick, and from there with another repair method. Closed loop."""

import math
from collections.abc import Iterator

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.errors import InputError
from roadmend.core.interfaces import Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import COLUMNS, Scene
from roadmend.recording.ticks import BagTick, BagTicks

_NANOSECONDS = 1_000_000_000


class Switchover:
    """A repairer that drives what a bag holds until a moment, and what another repairer says from then on.

    Until then, and at that moment, it holds scene and decision of the policy against the recorded ones. The other repairer sees
    each scene from the start, so that it takes over with the memory it would have had.

    Args:
        ticks: the recorded run.
        repairer: who takes over.
        from_time: when [s of simulation time]; the recorded commands of all earlier ticks are driven.
        way_out: what else helps where the world differs, for the message.
    """

    def __init__(self, ticks: BagTicks, repairer: Repairer, from_time: float, way_out: str = "") -> None:
        self.name = repairer.name
        self._path = ticks.path
        self._recorded: Iterator[BagTick] = iter(ticks)
        self._repairer = repairer
        self._way_out = way_out
        self._from_ns = round(from_time * _NANOSECONDS)
        self._is_over = False  # whether the recorded part has been driven
        self.route: Route | None = None  # once an episode has begun

    def reset(self, route: Route) -> None:
        """Begin the episode."""
        self.route = route
        self._repairer.reset(route)

    def has_taken_over(self, time: float) -> bool:
        """Whether the other repairer drives at ``time`` [s]."""
        return round(time * _NANOSECONDS) >= self._from_ns

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """The answer to one tick.

        Raises:
            InputError: the world or the policy differs from the recorded one, or the bag has no command to drive.
        """
        answer = self._repairer.step(scene, decision)
        stamp = round(scene.time * _NANOSECONDS)
        if self._is_over:
            return answer
        recorded = self._check(scene, stamp)
        self._is_over = self.has_taken_over(scene.time)
        is_told = recorded.command is not None or not self._is_over  # from here on nothing is driven that it lacks
        if is_told and recorded.command != decision.command:
            how = f"the policy asks for {_shown(decision)}, then for {_shown(recorded.decision)}"
            raise self._differs(scene, how, "name who drove with --policy")
        if self._is_over:
            return answer
        if recorded.driven is None or recorded.repair is None:
            raise self._differs(scene, "the bag holds no command of the repair node")
        return recorded.repair

    def _check(self, scene: Scene, stamp: int) -> BagTick:
        recorded = next((tick for tick in self._recorded if tick.ego is not None), None)
        then = recorded.scene(self.route) if recorded is not None and self.route is not None else None
        if recorded is None or then is None or recorded.stamp != stamp:
            raise self._differs(scene, "the bag holds no scene of this tick")
        if scene.ego != then.ego:
            away = math.hypot(scene.ego.x - then.ego.x, scene.ego.y - then.ego.y)
            raise self._differs(scene, f"the ego is {away:.3g} m from where it was")
        for name in COLUMNS:
            if not np.array_equal(getattr(scene.objects, name), getattr(then.objects, name)):
                raise self._differs(scene, f"the {name} of the {len(scene.objects)} objects is not what it was")
        if not np.array_equal(scene.signals, then.signals):
            raise self._differs(scene, "the traffic lights are not what they were")
        return recorded

    def _differs(self, scene: Scene, how: str, way_out: str = "") -> InputError:
        ways = ["take a bag of a lockstep run of this version", way_out or self._way_out]
        mend = ", or ".join(filter(None, ways))
        return InputError(str(self._path), f"the world differs at {scene.time:.2f} s: {how}", mend)


def _shown(decision: Decision | None) -> str:
    if decision is None:
        return "nothing"
    return f"{decision.command.action:+.4f}{' and a lane change' if decision.command.change_lane else ''}"
