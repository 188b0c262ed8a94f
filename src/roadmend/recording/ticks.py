"""A recorded episode tick by tick, in little memory however long it is. Needs no ROS."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.recording.reader import BagReader
from roadmend.recording.values import (
    command_of,
    ego_of,
    event_of,
    objects_of,
    repair_of,
    route_of,
    sized,
    stamp_of,
    trajectory_of,
)

LATE_NS = 1_000_000_000  # [ns] how much later than its tick a message may stand in a bag
_TYPES = {
    "ego": "nav_msgs/msg/Odometry",
    "objects": "roadmend_msgs/msg/ObjectList",
    "route": "roadmend_msgs/msg/Route",
    "events": "roadmend_msgs/msg/ScenarioEvent",
    "policy/command": "roadmend_msgs/msg/Command",
    "policy/trajectory": "roadmend_msgs/msg/Trajectory",
    "repair/command": "roadmend_msgs/msg/Command",
    "repair/state": "roadmend_msgs/msg/RepairState",
}


@dataclass(slots=True)
class BagTick:
    """What a bag holds of one tick; None where it has nothing, or nothing that can be read."""

    stamp: int  # [ns]
    route: Route | None = None  # where an episode begins
    ego: EgoState | None = None
    objects: ObjectList | None = None
    signals: NDArray[np.uint8] | None = None
    command: Command | None = None  # the policy's
    trajectory: Trajectory | None = None
    driven: Command | None = None  # what the repair node sent
    repair: Repair | None = None  # its account of that
    final: Event | None = None  # how the episode ended with this tick

    def scene(self, route: Route) -> Scene | None:
        """The scene as the nodes saw it, the ego as large as the route tells."""
        if self.ego is None or self.objects is None or self.signals is None:
            return None
        ego = sized(self.ego, route.ego_length, route.ego_width)
        return Scene(self.stamp * 1e-9, ego, self.objects, self.signals)

    @property
    def decision(self) -> Decision | None:
        """The policy's decision."""
        if self.command is None or self.trajectory is None:
            return None
        return Decision(self.command, self.trajectory)


class BagTicks:
    """The ticks of the one episode that a bag holds.

    Args:
        reader: the bag.

    Raises:
        InputError: the bag lacks odometry, objects or the route, without which no tick can be judged again.
    """

    def __init__(self, reader: BagReader) -> None:
        self.path = reader.path
        self._reader = reader
        self.topics = _topics(reader)  # the graph's name of a topic -> its name in the bag
        missing = [short for short in ("ego", "objects", "route") if short not in self.topics]
        if missing:
            raise InputError(
                str(reader.path), f"holds no {' and no '.join(missing)}", "name a bag that an episode was recorded into"
            )

    @property
    def namespace(self) -> str:
        """Namespace that the graph was recorded in; empty for the root."""
        return self.topics["ego"].removesuffix("/ego")

    def __iter__(self) -> Iterator[BagTick]:
        """The ticks in the order of their stamps.

        Raises:
            InputError: the bag is corrupt, or its route is unusable.
        """
        shorts = {name: short for short, name in self.topics.items()}
        open_ticks: dict[int, BagTick] = {}
        for message in self._reader.messages(list(shorts)):
            stamp = stamp_of(message.value)
            if stamp not in open_ticks:
                open_ticks[stamp] = BagTick(stamp)
                for done in sorted(known for known in open_ticks if known < stamp - LATE_NS):
                    yield open_ticks.pop(done)
            try:
                _take(open_ticks[stamp], shorts[message.topic], message.value)
            except (ValueError, IndexError) as error:
                where = f"{message.topic} at {stamp * 1e-9:.2f} s"
                raise InputError(str(self.path), f"{where}: {error}", "take another bag") from error
        for stamp in sorted(open_ticks):
            yield open_ticks[stamp]


def _topics(reader: BagReader) -> dict[str, str]:
    """Topics of the graph as they are named in the bag: perhaps in a namespace, then in the shortest one."""
    found = {}
    for short, kind in _TYPES.items():
        names = [
            name for name, topic in reader.topics.items() if topic.type_name == kind and name.endswith(f"/{short}")
        ]
        if names:
            found[short] = min(names, key=len)
    return found


def _take(tick: BagTick, short: str, value: Any) -> None:
    match short:
        case "ego":
            tick.ego = ego_of(value)
        case "objects":
            with contextlib.suppress(ValueError):  # a fault that the repair node has met as well, and answered
                tick.objects = objects_of(value)
                tick.signals = np.array(value.signal, dtype=np.uint8)
        case "route":
            tick.route = route_of(value)
        case "policy/command":
            tick.command = command_of(value)
        case "policy/trajectory":
            tick.trajectory = trajectory_of(value)
        case "repair/command":
            tick.driven = command_of(value)
        case "repair/state":
            tick.repair = repair_of(value)
        case "events":
            event = event_of(value)
            if event is not None and event.kind.is_final:
                tick.final = event
    if tick.repair is not None and tick.driven is not None:
        tick.repair = replace(tick.repair, command=tick.driven)
