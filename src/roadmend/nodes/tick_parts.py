"""What a tick is made of for repair_node: which messages are waited for, which belong to no tick, what they say."""

from collections.abc import Mapping
from dataclasses import dataclass

from rclpy.node import Node

from roadmend.core.command import Decision, Trajectory
from roadmend.core.command_age import CommandAge, age_of
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.nodes.inputs import COMMAND, TRAJECTORY
from roadmend.nodes.pairing import TickPairing
from roadmend.nodes.policy_watch import PERIOD_S
from roadmend.recording import messages

PARTS = ("ego", "objects", "command", "trajectory")
LEAST_PARTS = PARTS[:3]  # of a tick whose policy publishes no plan
_AHEAD_NS = 1_000_000_000  # [ns] a command is of no tick if its stamp lies so far after the newest odometry

Tick = Mapping[str, bytes]  # part -> its message as it came


@dataclass(frozen=True, slots=True)
class LateTick:
    """A tick that is to be answered without what it lacks."""

    stamp: int  # [ns]
    parts: Tick
    missing: tuple[str, ...]
    reason: str  # for people

    @property
    def lacks_scene(self) -> bool:
        """Whether odometry or objects are missing, rather than what the policy says."""
        return "ego" in self.missing or "objects" in self.missing


class TickParts:
    """Pairs the messages of ticks, with or without plans, and keeps out what belongs to none."""

    def __init__(self, node: Node, *, may_lack_plans: bool) -> None:
        """Begin.

        Args:
            node: the node, which sees who publishes.
            may_lack_plans: whether a policy that publishes no trajectory is not waited for with one.
        """
        self.pairing = TickPairing(*PARTS)
        self._node, self._may_lack_plans = node, may_lack_plans
        self._expected: tuple[str, ...] = PARTS
        self._looked_at = 0.0  # wall time [s]
        self._newest_ego = -1  # [ns] stamp
        self._stray_stamp = -1  # [ns] of the policy's last message if it belongs to no tick

    def begin(self) -> None:
        """A new episode: nothing of the last one counts."""
        self.pairing.clear()
        self._newest_ego = self._stray_stamp = -1

    def is_stray(self, part: str, stamp: int) -> bool:
        """Whether a message, which has just come, is of the policy and stamped [ns] far ahead of any tick."""
        if part == "ego":
            self._newest_ego = stamp
        elif part in ("command", "trajectory"):
            is_stray = 0 <= self._newest_ego < stamp - _AHEAD_NS
            self._stray_stamp = stamp if is_stray else -1
            return is_stray
        return False

    def look(self, now: float) -> None:
        """Look, now and then by the wall time [s], whether anybody publishes plans."""
        if not self._may_lack_plans or now - self._looked_at < PERIOD_S:
            return
        self._looked_at = now
        has_plans = bool(TRAJECTORY.publishers(self._node)) and not TRAJECTORY.faults(self._node)
        self._expected = PARTS if has_plans else LEAST_PARTS
        self.pairing.expect(*self._expected)

    @property
    def is_held(self) -> bool:
        """Whether time stands still at the tick that waits: a simulator that holds the first one until it is answered."""
        oldest, newest = self.pairing.oldest(), self.pairing.waiting()
        if oldest is None or newest is None:
            return False
        return age_of(oldest[0], max(newest[0], self._newest_ego)) <= 0

    def take_late(self, now: float, ages: CommandAge, *, is_silent: bool) -> LateTick | None:
        """The tick to answer without what it lacks, if the oldest one is late; it and all before it are given up.

        What is answered is the newest tick that lacks no more than the oldest one: those between them are as late.

        Args:
            now: wall time [s].
            ages: how old a tick may become.
            is_silent: whether the last answer had to do without, too.
        """
        oldest = self.pairing.oldest()
        if oldest is None:
            return None
        stamp, parts, since = oldest
        age = age_of(stamp, max(stamp, self._newest_ego))
        if not ages.is_late(now - since, age, is_silent=is_silent):
            return None
        newest = self.pairing.newest_with(parts.keys())
        assert newest is not None  # the oldest one is among them
        self.pairing.give_up(newest[0])
        missing = self.missing(newest[1])
        lag = f", {age} ticks ago" if age else ""
        return LateTick(*newest, tuple(missing), f"no {', '.join(missing)} within {now - since:.2g} s{lag}")

    def missing(self, tick: Tick) -> list[str]:
        """What a tick still waits for."""
        return [part for part in self._expected if part not in tick]

    def decision(self, tick: Tick) -> Decision | None:
        """What the policy said; None where its part of the tick is not whole, a plan that is empty where none is due.

        Raises:
            ValueError: the bytes are no such messages.
        """
        if {"command", "trajectory"} & {*self.missing(tick)}:
            return None
        plan = Trajectory.empty()
        if "trajectory" in tick:
            plan = messages.trajectory_of(messages.TRAJECTORY.decode(tick["trajectory"]))
        return Decision(messages.command_of(messages.COMMAND.decode(tick["command"])), plan)

    def lack(self) -> str:
        """What the first tick waits for, for people."""
        if self._stray_stamp >= 0:
            stray, tick = self._stray_stamp * 1e-9, self._newest_ego * 1e-9
            return (
                f"the policy's messages are stamped {stray:.2f} s and belong to no tick, which is at {tick:.2f} s now; "
                f"copy header.stamp of the tick's odometry"
            )
        waiting = self.pairing.waiting()
        lacking = self.missing({} if waiting is None else waiting[1])
        faults = [*COMMAND.faults(self._node), *TRAJECTORY.faults(self._node)]
        wanted = ", ".join(lacking) or "a route"
        return "; ".join([f"waiting for the first complete tick, for want of {wanted}", *faults])


def scene_of(stamp: int, tick: Tick, route: Route | None) -> Scene | None:
    """What the tick ``stamp`` [ns] shows; None while odometry, objects or the route lack.

    Raises:
        ValueError: the bytes are no such messages.
    """
    if "ego" not in tick or "objects" not in tick or route is None:
        return None
    seen, signals = messages.objects_of(messages.OBJECTS.decode(tick["objects"]))
    ego = messages.ego_of(messages.EGO.decode(tick["ego"]), route.ego_length, route.ego_width)
    return Scene(stamp * 1e-9, ego, seen, signals)
