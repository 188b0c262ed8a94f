"""Messages to core types and back. The only place where the two meet."""

import itertools
import math
from array import array

import numpy as np
from builtin_interfaces.msg import Time
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from roadmend_msgs import msg
from std_msgs.msg import Header

from roadmend.core.command import Command, Trajectory
from roadmend.core.outcome import Event
from roadmend.core.repair import Repair
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import COLUMNS, EgoState, ObjectList
from roadmend.world.road_network import LaneMap

MAP_FRAME = "map"
BASE_FRAME = "base_link"
_NANOSECONDS = 1_000_000_000


def stamp_of(time: float) -> Time:
    """Simulation time [s] as a message stamp, rounded to the nanosecond."""
    nanoseconds = round(time * _NANOSECONDS)
    return Time(sec=nanoseconds // _NANOSECONDS, nanosec=nanoseconds % _NANOSECONDS)


def nanoseconds_of(stamp: Time) -> int:
    """A message stamp as whole nanoseconds: the key that pairs the messages of one tick."""
    return int(stamp.sec) * _NANOSECONDS + int(stamp.nanosec)


def header_of(time: float, frame: str = MAP_FRAME) -> Header:
    """Header for simulation time ``time`` [s]."""
    return Header(stamp=stamp_of(time), frame_id=frame)


def _doubles(values: NDArray[np.float64]) -> "array[float]":
    return array("d", values.tobytes())


def _floats(values: "array[float]") -> NDArray[np.float64]:
    return np.frombuffer(values, dtype=np.float64) if len(values) else np.empty(0, dtype=np.float64)


def ego_of(message: Odometry, length: float, width: float) -> EgoState:
    """The ego from odometry; its size [m] comes from the route message."""
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    twist = message.twist.twist
    return EgoState.from_quaternion(
        position.x, position.y, orientation.z, orientation.w, twist.linear.x, twist.angular.z, length, width
    )


def object_message_of(objects: ObjectList, signals: NDArray[np.uint8], header: Header) -> msg.ObjectList:
    """The object list as a message."""
    message = msg.ObjectList(header=header)
    message.id = array("I", objects.id.tobytes())
    message.kind = array("B", objects.kind.tobytes())
    message.x = _doubles(objects.x)
    message.y = _doubles(objects.y)
    message.yaw = _doubles(objects.yaw)
    message.speed = _doubles(objects.speed)
    message.acceleration = _doubles(objects.acceleration)
    message.yaw_rate = _doubles(objects.yaw_rate)
    message.length = _doubles(objects.length)
    message.width = _doubles(objects.width)
    message.signal = array("B", signals.tobytes())
    return message


def objects_of(message: msg.ObjectList) -> tuple[ObjectList, NDArray[np.uint8]]:
    """Object list and signals from a message.

    Raises:
        ValueError: the arrays differ in length.
    """
    objects = ObjectList.of(**{name: getattr(message, name) for name in COLUMNS})
    return objects, np.array(message.signal, dtype=np.uint8)


def command_message_of(command: Command, header: Header) -> msg.Command:
    """A command as a message."""
    return msg.Command(header=header, throttle=command.throttle, brake=command.brake, change_lane=command.change_lane)


def command_of(message: msg.Command) -> Command:
    """A command from a message; not checked, see Command.fault."""
    return Command(message.throttle, message.brake, message.change_lane)


def trajectory_message_of(trajectory: Trajectory, header: Header) -> msg.Trajectory:
    """A planned trajectory as a message."""
    return msg.Trajectory(
        header=header,
        interval=trajectory.interval,
        x=_doubles(trajectory.x),
        y=_doubles(trajectory.y),
        yaw=_doubles(trajectory.yaw),
        speed=_doubles(trajectory.speed),
        behaviour=trajectory.behaviour,
    )


def trajectory_of(message: msg.Trajectory) -> Trajectory:
    """A planned trajectory from a message."""
    return Trajectory(
        message.interval,
        _floats(message.x),
        _floats(message.y),
        _floats(message.yaw),
        _floats(message.speed),
        message.behaviour,
    )


def route_message_of(route: Route, header: Header) -> msg.Route:
    """A route as a message."""
    begins = np.cumsum([0, *(len(stage.x) for stage in route.stages[:-1])])
    return msg.Route(
        header=header,
        scenario=route.scenario,
        ego_length=route.ego_length,
        ego_width=route.ego_width,
        goal=route.goal,
        time_limit=route.time_limit,
        stage_begin=array("I", begins.astype(np.uint32).tobytes()),
        x=_doubles(np.concatenate([stage.x for stage in route.stages])),
        y=_doubles(np.concatenate([stage.y for stage in route.stages])),
        speed_limit=_doubles(np.concatenate([stage.speed_limit for stage in route.stages])),
        change_begin=array("d", [window.begin for window in route.windows]),
        change_end=array("d", [window.end for window in route.windows]),
        zone_stage=array("I", [zone.stage for zone in route.zones]),
        zone_begin=array("d", [zone.begin for zone in route.zones]),
        zone_end=array("d", [zone.end for zone in route.zones]),
        zone_rule=array("B", [int(zone.rule) for zone in route.zones]),
        zone_signal=array("i", [zone.signal for zone in route.zones]),
    )


def route_of(message: msg.Route) -> Route:
    """A route from a message.

    Raises:
        ValueError: the arrays do not fit together, a stage has less than two points, or a rule is unknown.
    """
    begins = [*message.stage_begin, len(message.x)]
    if not len(message.x) == len(message.y) == len(message.speed_limit):
        raise ValueError("route: the arrays of its points differ in length")
    if len(begins) < 2 or begins[0] != 0 or any(end - begin < 2 for begin, end in itertools.pairwise(begins)):
        raise ValueError("route: it needs stages of at least two points each, one after another")
    x, y, limits = np.array(message.x), np.array(message.y), np.array(message.speed_limit)
    stages = tuple(
        Stage(x[begin:end].copy(), y[begin:end].copy(), limits[begin:end].copy())
        for begin, end in itertools.pairwise(begins)
    )
    windows = tuple(Window(begin, end) for begin, end in zip(message.change_begin, message.change_end, strict=True))
    zones = tuple(
        Zone(int(stage), begin, end, RightOfWay(rule), int(signal))
        for stage, begin, end, rule, signal in zip(
            message.zone_stage,
            message.zone_begin,
            message.zone_end,
            message.zone_rule,
            message.zone_signal,
            strict=True,
        )
    )
    return Route(
        message.scenario,
        message.ego_length,
        message.ego_width,
        message.goal,
        message.time_limit,
        stages,
        windows,
        zones,
    )


def repair_message_of(repair: Repair, method: str, header: Header) -> msg.RepairState:
    """The account of one tick's repair as a message."""
    return msg.RepairState(
        header=header,
        state=int(repair.status),
        method=method,
        score=repair.score,
        threshold=repair.threshold,
        policy_action=_finite_or_nan(repair.policy_action),
        repair_action=_finite_or_nan(repair.repair_action),
        final_action=repair.final_action,
        intervened=repair.intervened,
        dropped_objects=repair.dropped_objects,
        trigger_id=array("I", [trigger.object_id for trigger in repair.triggers]),
        trigger_weight=array("d", [trigger.weight for trigger in repair.triggers]),
        reason=repair.reason,
    )


def _finite_or_nan(value: float) -> float:
    return value if math.isfinite(value) else math.nan


def event_message_of(event: Event) -> msg.ScenarioEvent:
    """A scenario event as a message."""
    return msg.ScenarioEvent(
        header=header_of(event.time),
        kind=int(event.kind),
        object_id=array("I", event.object_ids),
        object_name=list(event.object_names),
        text=event.text,
        object_kind=array("B", event.object_kinds),
        blame=int(event.blame),
        impact_speed=math.nan if event.impact_speed is None else event.impact_speed,
    )


def map_message_of(lanes: LaneMap, header: Header) -> msg.Map:
    """The road network as a message."""
    return msg.Map(
        header=header,
        lane_begin=array("I", lanes.begin.astype(np.uint32).tobytes()),
        lane_kind=array("B", lanes.kind.tobytes()),
        lane_width=array("f", lanes.width.astype(np.float32).tobytes()),
        x=_doubles(lanes.x),
        y=_doubles(lanes.y),
    )
