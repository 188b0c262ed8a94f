"""A recorded episode tick by tick, in little memory however long it is. The one reader of episodes. Needs no ROS."""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.recording import messages, topics
from roadmend.recording.reader import BagReader
from roadmend.world.road_network import LaneMap

LATE_NS = 1_000_000_000  # [ns] how much later than its tick a message may stand in a bag


@dataclass(slots=True)
class BagTick:
    """What a bag holds of one tick; None where it has nothing, or nothing that can be read."""

    stamp: int  # [ns]
    time_ns: int = 0  # latest log time of its messages [ns]: the stamp, where these are of simulation time
    route: Route | None = None  # where an episode begins
    lanes: LaneMap | None = None  # likewise
    ego: EgoState | None = None
    objects: ObjectList | None = None
    signals: NDArray[np.uint8] | None = None
    command: Command | None = None  # the policy's
    trajectory: Trajectory | None = None
    driven: Command | None = None  # what the repair node sent
    repair: Repair | None = None  # its account of that
    events: list[Event] = field(default_factory=list)

    def scene(self, route: Route) -> Scene | None:
        """The scene as the nodes saw it, the ego as large as the route tells."""
        if self.ego is None or self.objects is None or self.signals is None:
            return None
        return Scene(self.stamp * 1e-9, messages.sized(self.ego, route), self.objects, self.signals)

    @property
    def decision(self) -> Decision | None:
        """The policy's decision."""
        if self.command is None or self.trajectory is None:
            return None
        return Decision(self.command, self.trajectory)

    @property
    def final(self) -> Event | None:
        """How the episode ended with this tick."""
        return next((event for event in reversed(self.events) if event.kind.is_final), None)


class BagTicks:
    """The ticks of the one episode that a bag holds.

    Args:
        reader: the bag.
        needed: topics that it must have; without these three no tick can be judged again.

    Raises:
        InputError: the bag lacks one of them.
    """

    def __init__(self, reader: BagReader, needed: Sequence[str] = (topics.EGO, topics.OBJECTS, topics.ROUTE)) -> None:
        self.path = reader.path
        self._reader = reader
        self.topics = _topics(reader)  # the graph's name of a topic -> its name in the bag
        missing = [topic for topic in needed if topic not in self.topics]
        if missing:
            raise InputError(
                str(reader.path), f"holds no {' and no '.join(missing)}", "name a bag that an episode was recorded into"
            )

    @property
    def namespace(self) -> str:
        """Namespace that the graph was recorded in; empty for the root."""
        return self.topics[topics.EGO].removesuffix(f"/{topics.EGO}")

    def __iter__(self) -> Iterator[BagTick]:
        """The ticks in the order of their stamps.

        Raises:
            InputError: the bag is corrupt, or its route is unusable.
        """
        takers = {name: _TAKERS[topic] for topic, name in self.topics.items()}
        open_ticks: dict[int, BagTick] = {}
        for record in self._reader.records(list(takers)):
            try:
                value = self._reader.decode(record)
            except InputError:
                if takers[record.topic] is _take_route:
                    raise
                continue  # somebody has sent bytes that are no such message; who waited for one has said so
            stamp = messages.stamp_of_bytes(record.data)
            if stamp not in open_ticks:
                open_ticks[stamp] = BagTick(stamp)
                for done in sorted(known for known in open_ticks if known < stamp - LATE_NS):
                    yield open_ticks.pop(done)
            tick = open_ticks[stamp]
            tick.time_ns = max(tick.time_ns, record.time_ns)
            try:
                takers[record.topic](tick, value)
            except (ValueError, IndexError) as error:
                where = f"{record.topic} at {stamp * 1e-9:.2f} s"
                raise InputError(str(self.path), f"{where}: {error}", "take another bag") from error
        for stamp in sorted(open_ticks):
            yield open_ticks[stamp]


def _topics(reader: BagReader) -> dict[str, str]:
    """Topics of the graph as they are named in the bag: perhaps in a namespace, then in the shortest one that is no shadow's."""
    found = {}
    for topic, kind in topics.TYPES.items():
        names = [name for name, one in reader.topics.items() if one.type_name == kind and name.endswith(f"/{topic}")]
        if (name := topics.own(names)) is not None:
            found[topic] = name
    return found


def _take_ego(tick: BagTick, message: Any) -> None:
    tick.ego = messages.ego_of(message)


def _take_objects(tick: BagTick, message: Any) -> None:
    with contextlib.suppress(ValueError):  # a fault that the repair node has met as well, and answered
        tick.objects, tick.signals = messages.objects_of(message)


def _take_route(tick: BagTick, message: Any) -> None:
    tick.route = messages.route_of(message)


def _take_map(tick: BagTick, message: Any) -> None:
    tick.lanes = messages.lanes_of(message)


def _take_event(tick: BagTick, message: Any) -> None:
    event = messages.event_of(message)
    if event is not None:
        tick.events.append(event)


def _take_policy_command(tick: BagTick, message: Any) -> None:
    tick.command = messages.command_of(message)


def _take_trajectory(tick: BagTick, message: Any) -> None:
    tick.trajectory = messages.trajectory_of(message)


def _take_repair_command(tick: BagTick, message: Any) -> None:
    tick.driven = messages.command_of(message)
    _join(tick)


def _take_repair_state(tick: BagTick, message: Any) -> None:
    tick.repair = messages.repair_of(message)
    _join(tick)


def _join(tick: BagTick) -> None:
    """The command that was sent is exact; its account knows only the difference of throttle and brake."""
    if tick.repair is not None and tick.driven is not None:
        tick.repair = replace(tick.repair, command=tick.driven)


_TAKERS: dict[str, Callable[[BagTick, Any], None]] = {
    topics.EGO: _take_ego,
    topics.OBJECTS: _take_objects,
    topics.ROUTE: _take_route,
    topics.MAP: _take_map,
    topics.EVENTS: _take_event,
    topics.POLICY_COMMAND: _take_policy_command,
    topics.POLICY_TRAJECTORY: _take_trajectory,
    topics.REPAIR_COMMAND: _take_repair_command,
    topics.REPAIR_STATE: _take_repair_state,
}
