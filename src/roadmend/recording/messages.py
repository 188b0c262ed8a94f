"""Core types to messages and back, field by field. The only place where the two meet. Needs no ROS.

What is read from a message is a copy: it may be changed, and does not hold on to the message's bytes.
"""

import itertools
import math
import struct
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from roadmend.core.appearance import kind_of, status_of
from roadmend.core.command import Command, Trajectory
from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.repair import Repair, RepairTrigger
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import COLUMNS, EgoState, ObjectList
from roadmend.recording import topics
from roadmend.recording.codec import MessageType
from roadmend.world.road_network import LaneMap

Floats = NDArray[np.float64]
_Given = ParamSpec("_Given")
_Read = TypeVar("_Read")

MAP_FRAME = "map"
BASE_FRAME = "base_link"
EGO_SIZE = (4.8, 1.8)  # [m] length and width where no route has told them
NANOSECONDS = 1_000_000_000  # in a second
LATEST = (1 << 31) * NANOSECONDS - 1  # [ns] the last moment that a stamp can say

TIME = MessageType("builtin_interfaces/msg/Time")
HEADER = MessageType("std_msgs/msg/Header")
CLOCK = MessageType("rosgraph_msgs/msg/Clock")
POINT = MessageType("geometry_msgs/msg/Point")
VECTOR = MessageType("geometry_msgs/msg/Vector3")
QUATERNION = MessageType("geometry_msgs/msg/Quaternion")
POSE = MessageType("geometry_msgs/msg/Pose")
TWIST = MessageType("geometry_msgs/msg/Twist")
POSE_WITH_COVARIANCE = MessageType("geometry_msgs/msg/PoseWithCovariance")
TWIST_WITH_COVARIANCE = MessageType("geometry_msgs/msg/TwistWithCovariance")
EGO = MessageType(topics.TYPES[topics.EGO])
OBJECTS = MessageType(topics.TYPES[topics.OBJECTS])
ROUTE = MessageType(topics.TYPES[topics.ROUTE])
MAP = MessageType(topics.TYPES[topics.MAP])
EVENT = MessageType(topics.TYPES[topics.EVENTS])
COMMAND = MessageType(topics.TYPES[topics.POLICY_COMMAND])
TRAJECTORY = MessageType(topics.TYPES[topics.POLICY_TRAJECTORY])
REPAIR = MessageType(topics.TYPES[topics.REPAIR_STATE])

_STAMPS = (struct.Struct(">iI"), struct.Struct("<iI"))  # by the lowest bit of the encapsulation: big, little endian


def _told(read: Callable[_Given, _Read]) -> Callable[_Given, _Read]:
    """What reads a message, and says so where the message lacks a field: a bag brings its own definitions along."""

    @wraps(read)
    def told(*given: _Given.args, **named: _Given.kwargs) -> _Read:
        try:
            return read(*given, **named)
        except AttributeError as error:
            raise ValueError(f"its definition lacks a field: {error}") from error

    return told


# -- time -------------------------------------------------------------------------------------------------------------


def stamp_message_of(nanoseconds: int) -> Any:
    """A moment of simulation time [ns] as a message; one that no stamp can say as the nearest that one can."""
    nanoseconds = min(max(0, nanoseconds), LATEST)
    return TIME(sec=nanoseconds // NANOSECONDS, nanosec=nanoseconds % NANOSECONDS)


def header_at(nanoseconds: int) -> Any:
    """Header for the tick with this stamp [ns], in the frame of the map."""
    return HEADER(stamp=stamp_message_of(nanoseconds), frame_id=MAP_FRAME)


def header_of(time: float) -> Any:
    """Header for simulation time ``time`` [s], rounded to the nanosecond, in the frame of the map."""
    return header_at(round(time * NANOSECONDS))


def clock_message_of(time: float) -> Any:
    """Simulation time [s] as the clock tells it."""
    return CLOCK(clock=stamp_message_of(round(time * NANOSECONDS)))


def stamp_of(header: Any) -> int:
    """A header's stamp [ns]: the key that pairs the messages of one tick."""
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def stamp_of_bytes(data: bytes) -> int:
    """Stamp [ns] of a serialized message that begins with a header.

    Raises:
        ValueError: there are too few bytes.
    """
    if len(data) < 12:
        raise ValueError(f"{len(data)} bytes are too few for a header")
    seconds, nanoseconds = _STAMPS[data[1] & 1].unpack_from(data, 4)  # behind the encapsulation
    return int(seconds) * NANOSECONDS + int(nanoseconds)


# -- what is seen -----------------------------------------------------------------------------------------------------


def ego_message_of(ego: EgoState, header: Any) -> Any:
    """The ego as odometry."""
    pose = POSE(position=POINT(x=ego.x, y=ego.y), orientation=QUATERNION(z=ego.orientation_z, w=ego.orientation_w))
    twist = TWIST(linear=VECTOR(x=ego.speed), angular=VECTOR(z=ego.yaw_rate))
    return EGO(
        header=header,
        child_frame_id=BASE_FRAME,
        pose=POSE_WITH_COVARIANCE(pose=pose),
        twist=TWIST_WITH_COVARIANCE(twist=twist),
    )


@_told
def ego_of(message: Any, length: float = EGO_SIZE[0], width: float = EGO_SIZE[1]) -> EgoState:
    """The ego from odometry; its size [m] comes from the route."""
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    twist = message.twist.twist
    return EgoState.from_quaternion(
        position.x, position.y, orientation.z, orientation.w, twist.linear.x, twist.angular.z, length, width
    )


def sized(ego: EgoState, route: Route) -> EgoState:
    """The ego with the size that its route tells."""
    return EgoState.from_quaternion(
        ego.x,
        ego.y,
        ego.orientation_z,
        ego.orientation_w,
        ego.speed,
        ego.yaw_rate,
        route.ego_length,
        route.ego_width,
    )


def object_message_of(objects: ObjectList, signals: NDArray[np.uint8], header: Any) -> Any:
    """The participants and the traffic lights."""
    return OBJECTS(
        header=header,
        **{name: np.ascontiguousarray(objects.table[name]) for name in COLUMNS},
        signal=signals,
    )


@_told
def objects_of(message: Any) -> tuple[ObjectList, NDArray[np.uint8]]:
    """The participants and the traffic lights.

    Raises:
        ValueError: the arrays differ in length.
    """
    objects = ObjectList.of(**{name: getattr(message, name) for name in COLUMNS})
    return objects, np.array(message.signal, dtype=np.uint8)


# -- what is decided --------------------------------------------------------------------------------------------------


def command_message_of(command: Command, header: Any) -> Any:
    """A command."""
    return COMMAND(header=header, throttle=command.throttle, brake=command.brake, change_lane=command.change_lane)


@_told
def command_of(message: Any) -> Command:
    """A command; not checked, see Command.fault."""
    return Command(message.throttle, message.brake, message.change_lane)


def trajectory_message_of(trajectory: Trajectory, header: Any) -> Any:
    """A planned trajectory."""
    return TRAJECTORY(
        header=header,
        interval=trajectory.interval,
        x=np.ascontiguousarray(trajectory.x),
        y=np.ascontiguousarray(trajectory.y),
        yaw=np.ascontiguousarray(trajectory.yaw),
        speed=np.ascontiguousarray(trajectory.speed),
        behaviour=trajectory.behaviour,
    )


@_told
def trajectory_of(message: Any) -> Trajectory:
    """A planned trajectory."""
    x, y, yaw, speed = (floats_of(part) for part in (message.x, message.y, message.yaw, message.speed))
    return Trajectory(message.interval, x, y, yaw, speed, message.behaviour)


def repair_message_of(repair: Repair, method: str, header: Any) -> Any:
    """The account of one tick's repair."""
    return REPAIR(
        header=header,
        state=int(repair.status),
        method=method,
        score=repair.score,
        threshold=repair.threshold,
        worth=math.nan if repair.worth is None else repair.worth,
        policy_action=_finite_or_nan(repair.policy_action),
        repair_action=_finite_or_nan(repair.repair_action),
        final_action=repair.final_action,
        intervened=repair.intervened,
        dropped_objects=repair.dropped_objects,
        trigger_id=np.array([trigger.object_id for trigger in repair.triggers], dtype=np.uint32),
        trigger_weight=np.array([trigger.weight for trigger in repair.triggers], dtype=np.float64),
        held_back=repair.held_back,
        reason=repair.reason,
    )


def renewed_repair_message_of(message: Any) -> Any:
    """The account of another version as one of this; where that one tells no worth, it is no number."""
    empty = REPAIR(worth=math.nan)
    return REPAIR(**{name: getattr(message, name, getattr(empty, name)) for name in empty.__dataclass_fields__})


@_told
def repair_of(message: Any) -> Repair:
    """The account of one tick's repair, with the command that its final action stands for.

    Bags of earlier versions tell no worth, and held nothing back.

    Raises:
        ValueError: the arrays differ in length.
    """
    triggers = zip(message.trigger_id.tolist(), message.trigger_weight.tolist(), strict=True)
    worth = getattr(message, "worth", math.nan)
    return Repair(
        Command.from_action(message.final_action),
        status_of(message.state),
        message.score,
        message.threshold,
        message.policy_action,
        message.repair_action,
        message.intervened,
        message.dropped_objects,
        tuple(RepairTrigger(identity, weight) for identity, weight in triggers),
        message.reason,
        worth if math.isfinite(worth) else None,
        getattr(message, "held_back", False),
    )


def _finite_or_nan(value: float) -> float:
    return value if math.isfinite(value) else math.nan


# -- the episode ------------------------------------------------------------------------------------------------------


def event_message_of(event: Event) -> Any:
    """Something that happened to the episode."""
    return EVENT(
        header=header_of(event.time),
        kind=int(event.kind),
        object_id=np.array(event.object_ids, dtype=np.uint32),
        object_name=list(event.object_names),
        text=event.text,
        object_kind=np.array(event.object_kinds, dtype=np.uint8),
        blame=int(event.blame),
        impact_speed=math.nan if event.impact_speed is None else event.impact_speed,
    )


@_told
def event_of(message: Any) -> Event | None:
    """Something that happened to the episode; None where it is of a kind that is not known here.

    Bags of earlier versions tell neither the kinds of the others nor the blame and the speed of a collision.
    """
    if message.kind not in set(EventKind):
        return None
    kinds, blame = getattr(message, "object_kind", ()), getattr(message, "blame", Blame.UNKNOWN)
    impact_speed = getattr(message, "impact_speed", math.nan)
    return Event(
        stamp_of(message.header) * 1e-9,
        EventKind(message.kind),
        message.text,
        tuple(message.object_id.tolist()),
        tuple(message.object_name),
        tuple(kind_of(int(kind)) for kind in kinds),
        Blame(blame) if blame in set(Blame) else Blame.UNKNOWN,
        impact_speed if math.isfinite(impact_speed) else None,
    )


def route_message_of(route: Route, header: Any) -> Any:
    """A route."""
    begins = np.cumsum([0, *(len(stage.x) for stage in route.stages[:-1])])
    return ROUTE(
        header=header,
        scenario=route.scenario,
        ego_length=route.ego_length,
        ego_width=route.ego_width,
        goal=route.goal,
        time_limit=route.time_limit,
        stage_begin=begins.astype(np.uint32),
        x=np.concatenate([stage.x for stage in route.stages]),
        y=np.concatenate([stage.y for stage in route.stages]),
        speed_limit=np.concatenate([stage.speed_limit for stage in route.stages]),
        change_begin=floats_of([window.begin for window in route.windows]),
        change_end=floats_of([window.end for window in route.windows]),
        zone_stage=np.array([zone.stage for zone in route.zones], dtype=np.uint32),
        zone_begin=floats_of([zone.begin for zone in route.zones]),
        zone_end=floats_of([zone.end for zone in route.zones]),
        zone_rule=np.array([zone.rule for zone in route.zones], dtype=np.uint8),
        zone_signal=np.array([zone.signal for zone in route.zones], dtype=np.int32),
    )


@_told
def route_of(message: Any) -> Route:
    """A route.

    Raises:
        ValueError: the arrays do not fit together, a stage has less than two points, a zone lies on no stage, there are
            more windows than stages to change to, a rule is unknown, or the route has a fault (``Route.fault``).
    """
    x, y, limits = floats_of(message.x), floats_of(message.y), floats_of(message.speed_limit)
    begins = [*message.stage_begin.tolist(), len(x)]
    if not len(x) == len(y) == len(limits):
        raise ValueError("route: the arrays of its points differ in length")
    if len(begins) < 2 or begins[0] != 0 or any(end - begin < 2 for begin, end in itertools.pairwise(begins)):
        raise ValueError("route: it needs stages of at least two points each, one after another")
    stages = tuple(
        Stage(x[begin:end].copy(), y[begin:end].copy(), limits[begin:end].copy())
        for begin, end in itertools.pairwise(begins)
    )
    if len(message.change_begin) >= len(stages):
        raise ValueError(f"route: there are {len(message.change_begin)} windows between {len(stages)} stages")
    windows = zip(message.change_begin.tolist(), message.change_end.tolist(), strict=True)
    for stage in message.zone_stage.tolist():
        if not 0 <= stage < len(stages):  # below 0 by the definition of another bag
            raise ValueError(f"route: a zone lies on stage {stage} of {len(stages)}, counted from 0")
    columns = (message.zone_stage, message.zone_begin, message.zone_end, message.zone_rule, message.zone_signal)
    zones = zip(*(column.tolist() for column in columns), strict=True)
    route = Route(
        message.scenario,
        message.ego_length,
        message.ego_width,
        message.goal,
        message.time_limit,
        stages,
        tuple(Window(begin, end) for begin, end in windows),
        tuple(Zone(stage, begin, end, RightOfWay(rule), signal) for stage, begin, end, rule, signal in zones),
    )
    if fault := route.fault:
        raise ValueError(f"route: {fault}")
    return route


def map_message_of(lanes: LaneMap, header: Any) -> Any:
    """The road network."""
    return MAP(
        header=header,
        lane_begin=lanes.begin.astype(np.uint32),
        lane_kind=lanes.kind,
        lane_width=lanes.width.astype(np.float32),
        x=lanes.x,
        y=lanes.y,
    )


@_told
def lanes_of(message: Any) -> LaneMap:
    """The road network.

    Raises:
        ValueError: the arrays do not fit together.
    """
    begin, kind = np.array(message.lane_begin, dtype=np.int64), np.array(message.lane_kind, dtype=np.uint8)
    width, x, y = (floats_of(values) for values in (message.lane_width, message.x, message.y))
    if not len(begin) == len(kind) == len(width) or len(x) != len(y):
        raise ValueError("map: the arrays of its lanes or of its points differ in length")
    if np.any(np.diff(begin, prepend=0, append=len(x)) < 0):
        raise ValueError("map: its lanes do not follow one another")
    return LaneMap(begin, kind, width, x, y)


def floats_of(values: Any) -> Floats:
    """Numbers as an array of their own."""
    return np.array(values, dtype=np.float64)
