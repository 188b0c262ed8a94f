"""A recorded episode as core types, read from its bag. Needs no ROS."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from roadmend.core.command import Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList
from roadmend.recording.reader import BagReader
from roadmend.recording.values import (
    ego_of,
    event_of,
    floats_of,
    objects_of,
    repair_of,
    route_of,
    sized,
    stamp_of,
    trajectory_of,
)
from roadmend.world.road_network import LaneMap

_TOPICS = {
    "ego": "nav_msgs/msg/Odometry",
    "objects": "roadmend_msgs/msg/ObjectList",
    "route": "roadmend_msgs/msg/Route",
    "map": "roadmend_msgs/msg/Map",
    "events": "roadmend_msgs/msg/ScenarioEvent",
    "policy/trajectory": "roadmend_msgs/msg/Trajectory",
    "repair/state": "roadmend_msgs/msg/RepairState",
}


@dataclass(slots=True)
class BagEpisode:
    """What a bag tells of an episode, by the stamp [ns] of each tick; a bag may lack anything but the ego."""

    path: Path
    ego: dict[int, EgoState] = field(default_factory=dict)
    objects: dict[int, ObjectList] = field(default_factory=dict)
    trajectories: dict[int, Trajectory] = field(default_factory=dict)
    repairs: dict[int, Repair] = field(default_factory=dict)
    route: Route | None = None
    lanes: LaneMap | None = None
    outcome: str = ""
    events: list[Event] = field(default_factory=list)
    account: dict[str, str] = field(default_factory=dict)  # what the recorder says of the run

    @property
    def stamps(self) -> list[int]:
        """Stamps of the ticks [ns], rising."""
        return sorted(self.ego)


def read_episode(path: Path) -> BagEpisode:
    """Read the one episode that a bag holds; raises what ``episode_of`` does, and if there is no such bag."""
    return episode_of(BagReader(path))


def episode_of(reader: BagReader) -> BagEpisode:
    """Read the one episode that an open bag holds.

    Raises:
        InputError: the bag is cut short, or nothing of an ego is in it.
    """
    path = reader.path
    names = {name: short for short, name in _names(reader)}
    episode = BagEpisode(path, account=reader.metadata.get("roadmend", {}))
    for message in reader.messages(list(names)):
        value, short = message.value, names[message.topic]
        stamp = stamp_of(value)
        try:
            _take(episode, short, stamp, value)
        except (ValueError, IndexError) as error:
            raise InputError(
                str(path), f"{message.topic} at {stamp * 1e-9:.2f} s: {error}", "take another bag"
            ) from error
    if not episode.ego:
        raise InputError(str(path), "holds no odometry of an ego", "name a bag that an episode was recorded into")
    if episode.route is not None:
        size = (episode.route.ego_length, episode.route.ego_width)
        episode.ego = {stamp: sized(ego, *size) for stamp, ego in episode.ego.items()}
    return episode


def _names(reader: BagReader) -> Iterator[tuple[str, str]]:
    """Topics of the graph as they are named in the bag: perhaps in a namespace."""
    for short, kind in _TOPICS.items():
        found = [
            name for name, topic in reader.topics.items() if topic.type_name == kind and name.endswith(f"/{short}")
        ]
        if found:
            yield short, min(found, key=len)


def _take(episode: BagEpisode, short: str, stamp: int, value: Any) -> None:
    match short:
        case "ego":
            episode.ego[stamp] = ego_of(value)
        case "objects":
            episode.objects[stamp] = objects_of(value)
        case "policy/trajectory":
            episode.trajectories[stamp] = trajectory_of(value)
        case "repair/state":
            episode.repairs[stamp] = repair_of(value)
        case "route":
            episode.route = route_of(value)
        case "map":
            episode.lanes = LaneMap(
                np.asarray(value.lane_begin, dtype=np.int64),
                np.asarray(value.lane_kind, dtype=np.uint8),
                floats_of(value.lane_width),
                floats_of(value.x),
                floats_of(value.y),
            )
        case "events":
            _take_event(episode, event_of(value))


def _take_event(episode: BagEpisode, event: Event | None) -> None:
    if event is None:
        return
    episode.events.append(event)
    if event.kind is EventKind.STARTED:
        episode.outcome = ""
    elif event.kind.is_final:
        episode.outcome = event.kind.name.lower().replace("_", " ")
