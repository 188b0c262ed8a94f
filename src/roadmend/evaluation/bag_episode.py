"""A recorded episode as core types, read from its bag. Needs no ROS."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.geometry import outline_distances
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair, Trigger
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import EgoState, ObjectList
from roadmend.evaluation.scene_layers import LaneMap, Trail
from roadmend.evaluation.scene_style import status_of
from roadmend.evaluation.scene_timeline import SILENT, Timeline
from roadmend.recording.reader import BagReader

Floats = NDArray[np.float64]

EGO_SIZE = (4.8, 1.8)  # [m] where no route has told it
DISTANCE_EXACT = 60.0  # [m] up to which distances are those between outlines
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

    def timeline(self) -> Timeline:
        """One value a tick."""
        stamps = self.stamps
        repairs = [self.repairs.get(stamp) for stamp in stamps]
        return Timeline(
            np.array(stamps, dtype=np.float64) * 1e-9,
            np.array([self.ego[stamp].speed for stamp in stamps]),
            np.array([self._distance(stamp) for stamp in stamps]),
            _column(repairs, "score"),
            _column(repairs, "threshold"),
            _column(repairs, "policy_action"),
            _column(repairs, "final_action"),
            np.array([repair is not None and repair.intervened for repair in repairs], dtype=np.bool_),
            np.array([SILENT if repair is None else repair.status for repair in repairs], dtype=np.int64),
            tuple(self.events),
        )

    def trail(self, until: int) -> Trail:
        """The way driven up to a stamp [ns]."""
        stamps = [stamp for stamp in self.stamps if stamp <= until]
        repairs = [self.repairs.get(stamp) for stamp in stamps]
        return Trail(
            np.array([self.ego[stamp].x for stamp in stamps]),
            np.array([self.ego[stamp].y for stamp in stamps]),
            np.array([repair is not None and repair.intervened for repair in repairs], dtype=np.bool_),
        )

    def _distance(self, stamp: int) -> float:
        ego, objects = self.ego[stamp], self.objects.get(stamp)
        if objects is None or not len(objects):
            return math.nan
        distances = outline_distances(
            ego.x, ego.y, ego.yaw, ego.length, ego.width,
            objects.x, objects.y, objects.yaw, objects.length, objects.width, DISTANCE_EXACT,
        )  # fmt: skip
        return float(np.nanmin(distances)) if np.isfinite(distances).any() else math.nan


def read_episode(path: Path) -> BagEpisode:
    """Read the one episode that a bag holds.

    Raises:
        InputError: there is no such bag, it is cut short, or nothing of an ego is in it.
    """
    reader = BagReader(path)
    names = {name: short for short, name in _names(reader)}
    episode = BagEpisode(path, account=reader.metadata.get("roadmend", {}))
    for message in reader.messages(list(names)):
        value, short = message.value, names[message.topic]
        stamp = value.header.stamp.sec * 1_000_000_000 + value.header.stamp.nanosec
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
        episode.ego = {stamp: _sized(ego, *size) for stamp, ego in episode.ego.items()}
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
            episode.ego[stamp] = _ego_of(value)
        case "objects":
            episode.objects[stamp] = _objects_of(value)
        case "policy/trajectory":
            x, y, yaw, speed = (_floats(part) for part in (value.x, value.y, value.yaw, value.speed))
            episode.trajectories[stamp] = Trajectory(float(value.interval), x, y, yaw, speed, value.behaviour)
        case "repair/state":
            episode.repairs[stamp] = _repair_of(value)
        case "route":
            episode.route = _route_of(value)
        case "map":
            episode.lanes = LaneMap(
                np.asarray(value.lane_begin, dtype=np.int64), np.asarray(value.lane_kind, dtype=np.uint8),
                _floats(value.lane_width), _floats(value.x), _floats(value.y),
            )  # fmt: skip
        case "events":
            _take_event(episode, stamp, int(value.kind), value.text)


def _take_event(episode: BagEpisode, stamp: int, code: int, text: str) -> None:
    if code not in set(EventKind):
        return
    kind = EventKind(code)
    episode.events.append(Event(stamp * 1e-9, kind, text))
    if kind is EventKind.STARTED:
        episode.outcome = ""
    elif kind.is_final:
        episode.outcome = kind.name.lower().replace("_", " ")


def _ego_of(value: Any) -> EgoState:
    pose, twist = value.pose.pose, value.twist.twist
    return EgoState.from_quaternion(
        pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w,
        twist.linear.x, twist.angular.z, *EGO_SIZE,
    )  # fmt: skip


def _sized(ego: EgoState, length: float, width: float) -> EgoState:
    return EgoState.from_quaternion(
        ego.x, ego.y, ego.orientation_z, ego.orientation_w, ego.speed, ego.yaw_rate, length, width
    )


def _objects_of(value: Any) -> ObjectList:
    columns = [
        _floats(column)
        for column in (
            value.x, value.y, value.yaw, value.speed, value.acceleration, value.yaw_rate, value.length, value.width,
        )
    ]  # fmt: skip
    if any(len(column) != len(value.id) for column in (value.kind, *columns)):
        raise ValueError("the arrays differ in length")
    return ObjectList(np.asarray(value.id, dtype=np.uint32), np.asarray(value.kind, dtype=np.uint8), *columns)


def _repair_of(value: Any) -> Repair:
    triggers = zip(value.trigger_id, value.trigger_weight, strict=True)
    return Repair(
        Command.from_action(float(value.final_action)), status_of(int(value.state)), float(value.score),
        float(value.threshold), float(value.policy_action), float(value.repair_action), bool(value.intervened),
        int(value.dropped_objects), tuple(Trigger(int(identity), float(weight)) for identity, weight in triggers),
        value.reason,
    )  # fmt: skip


def _route_of(value: Any) -> Route:
    begins = [*(int(begin) for begin in value.stage_begin), len(value.x)]
    x, y, limits = _floats(value.x), _floats(value.y), _floats(value.speed_limit)
    stages = tuple(Stage(x[begin:end], y[begin:end], limits[begin:end]) for begin, end in itertools.pairwise(begins))
    windows = zip(value.change_begin, value.change_end, strict=True)
    zones = zip(
        value.zone_stage, value.zone_begin, value.zone_end, value.zone_rule, value.zone_signal, strict=True
    )  # fmt: skip
    return Route(
        value.scenario, value.ego_length, value.ego_width, value.goal, value.time_limit, stages,
        tuple(Window(float(begin), float(end)) for begin, end in windows),
        tuple(
            Zone(int(stage), float(begin), float(end), RightOfWay(int(rule)), int(signal))
            for stage, begin, end, rule, signal in zones
        ),
    )  # fmt: skip


def _column(repairs: list[Repair | None], name: str) -> Floats:
    return np.array([math.nan if repair is None else getattr(repair, name) for repair in repairs], dtype=np.float64)


def _floats(values: Any) -> Floats:
    return np.array(values, dtype=np.float64)
