"""What another repair method would have done at every tick of a recorded run, beside what was done. Open loop."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.recording.ticks import BagTick, BagTicks
from roadmend.recording.topics import REPAIR_COMMAND, REPAIR_STATE
from roadmend.repair.guard import GuardedRepairer
from roadmend.world.ego import VehicleParameters


@dataclass(frozen=True, slots=True)
class ShadowSummary:
    """What was done (then) against what would have been done (now)."""

    ticks: int
    interventions_then: int | None  # None where no repair state was recorded
    interventions_now: int
    agreement: float  # share of the ticks with the same throttle and brake
    first_difference: float | None  # [s] simulation time; None where all agree
    acceleration_difference: float  # [m/s2] mean of |asked now - asked then|, before lag and drag
    not_asked: int = 0  # ticks whose answer is not the other method's, since something was missing or unusable
    not_asked_why: str = ""  # time, state and reason of the first one; empty where there is none


# What a repair node answers with the method's own judgement.
_JUDGED = {RepairStatus.PASS, RepairStatus.REPAIRED, RepairStatus.RESET}


class ShadowComparison:
    """Makes the summary, answer by answer."""

    def __init__(self) -> None:
        self.count = 0
        self._then = self._now = self._same = 0
        self._first: float | None = None
        self._difference = 0.0
        self._not_asked = 0
        self._first_not_asked: tuple[float, Repair] | None = None

    def add(self, time: float, done: Command, answer: Repair, speed: float, *, intervened: bool) -> None:
        """One answer of the other method, in any order.

        Args:
            time: of the simulation [s].
            done: what was driven on.
            answer: of the other method.
            speed: of the ego [m/s].
            intervened: whether the method of then had stepped in.
        """
        command = answer.command
        self.count += 1
        self._then += intervened
        self._now += answer.intervened
        if answer.status not in _JUDGED:
            self._not_asked += 1
            if self._first_not_asked is None or time < self._first_not_asked[0]:
                self._first_not_asked = time, answer
        if (command.throttle, command.brake) == (done.throttle, done.brake):
            self._same += 1
        elif self._first is None or time < self._first:
            self._first = time
        change = abs(asked_acceleration(command, speed) - asked_acceleration(done, speed))
        self._difference += change if math.isfinite(change) else 0.0

    def summary(self, *, is_repaired: bool = True) -> ShadowSummary:
        """Of all answers; there must be one. ``is_repaired``: whether it is known what the method of then did."""
        count = self.count
        then = self._then if is_repaired else None
        why = ""
        if self._first_not_asked is not None:
            time, answer = self._first_not_asked
            why = f"{time:.2f} s: {answer.status.name}, {answer.reason}"
        return ShadowSummary(
            count,
            then,
            self._now,
            self._same / count,
            self._first,
            self._difference / count,
            self._not_asked,
            why,
        )


Watcher = Callable[[BagTick, Repair], None]


def run_shadow(
    ticks: BagTicks, repairer: GuardedRepairer, watcher: Watcher = lambda _tick, _repair: None
) -> ShadowSummary:
    """Let a method judge every recorded tick. What it answers moves nothing: each scene is the recorded one.

    What was done is what the repair node sent; in a bag without one, what the policy asked.

    Args:
        ticks: the recorded run.
        repairer: the other method.
        watcher: called with each tick that was judged and the answer to it.

    Raises:
        InputError: the bag is corrupt, or no tick of it can be judged.
    """
    comparison = ShadowComparison()
    route: Route | None = None
    repaired = REPAIR_COMMAND in ticks.topics
    for tick in ticks:
        if tick.route is not None:
            route = tick.route
            repairer.reset(route)
        done = tick.driven if repaired else tick.command
        if route is None or done is None or tick.final is not None:
            continue  # nobody drives on the answer to the final tick
        answer = _answer(repairer, route, tick)
        watcher(tick, answer)
        speed = 0.0 if tick.ego is None else tick.ego.speed
        intervened = tick.repair is not None and tick.repair.intervened
        comparison.add(tick.stamp * 1e-9, done, answer, speed, intervened=intervened)
    if not comparison.count:
        raise InputError(
            str(ticks.path), "holds no command of a policy or a repair node", "name a bag of a run that was driven"
        )
    return comparison.summary(is_repaired=REPAIR_STATE in ticks.topics)


def asked_acceleration(command: Command, speed: float) -> float:
    """Acceleration [m/s2] that a command asks of the ego at ``speed`` [m/s], before lag, grip and resistance."""
    ego = VehicleParameters()
    drive = min(ego.acceleration_max, ego.power_per_mass / max(speed, 1.0))
    return drive * command.throttle - ego.brake_max * command.brake


def _answer(repairer: GuardedRepairer, route: Route, tick: BagTick) -> Repair:
    scene, decision = tick.scene(route), tick.decision
    if scene is None:
        return repairer.controlled_stop(
            RepairStatus.STALE_OBJECTS, "the bag lacks odometry or objects of this tick", None, decision
        )
    if decision is None:
        return repairer.controlled_stop(
            RepairStatus.STALE_COMMAND, "the bag lacks the policy's command or trajectory of this tick", scene
        )
    return repairer.step(scene, decision)
