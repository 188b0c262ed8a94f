"""Decoded messages of a bag as core types. Needs no ROS."""

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.appearance import status_of
from roadmend.core.command import Command, Trajectory
from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.repair import Repair, Trigger
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import COLUMNS, EgoState, ObjectKind, ObjectList

Floats = NDArray[np.float64]

EGO_SIZE = (4.8, 1.8)  # [m] where no route has told it


def ego_of(value: Any) -> EgoState:
    """The ego from odometry, as large as it is where no route has told its size."""
    pose, twist = value.pose.pose, value.twist.twist
    return EgoState.from_quaternion(
        pose.position.x,
        pose.position.y,
        pose.orientation.z,
        pose.orientation.w,
        twist.linear.x,
        twist.angular.z,
        *EGO_SIZE,
    )


def sized(ego: EgoState, length: float, width: float) -> EgoState:
    """The ego with the size [m] that its route tells."""
    return EgoState.from_quaternion(
        ego.x, ego.y, ego.orientation_z, ego.orientation_w, ego.speed, ego.yaw_rate, length, width
    )


def objects_of(value: Any) -> ObjectList:
    """The participants.

    Raises:
        ValueError: the arrays differ in length.
    """
    return ObjectList.of(**{name: getattr(value, name) for name in COLUMNS})


def repair_of(value: Any) -> Repair:
    """What a repair node said about one tick."""
    triggers = zip(value.trigger_id, value.trigger_weight, strict=True)
    return Repair(
        Command.from_action(float(value.final_action)),
        status_of(int(value.state)),
        float(value.score),
        float(value.threshold),
        float(value.policy_action),
        float(value.repair_action),
        bool(value.intervened),
        int(value.dropped_objects),
        tuple(Trigger(int(identity), float(weight)) for identity, weight in triggers),
        value.reason,
    )


def route_of(value: Any) -> Route:
    """The route.

    Raises:
        ValueError: the arrays differ in length, or a rule is unknown.
    """
    begins = [*(int(begin) for begin in value.stage_begin), len(value.x)]
    x, y, limits = floats_of(value.x), floats_of(value.y), floats_of(value.speed_limit)
    stages = tuple(Stage(x[begin:end], y[begin:end], limits[begin:end]) for begin, end in itertools.pairwise(begins))
    windows = zip(value.change_begin, value.change_end, strict=True)
    zones = zip(value.zone_stage, value.zone_begin, value.zone_end, value.zone_rule, value.zone_signal, strict=True)
    return Route(
        value.scenario,
        value.ego_length,
        value.ego_width,
        value.goal,
        value.time_limit,
        stages,
        tuple(Window(float(begin), float(end)) for begin, end in windows),
        tuple(
            Zone(int(stage), float(begin), float(end), RightOfWay(int(rule)), int(signal))
            for stage, begin, end, rule, signal in zones
        ),
    )


def trajectory_of(value: Any) -> Trajectory:
    """The planned trajectory."""
    x, y, yaw, speed = (floats_of(part) for part in (value.x, value.y, value.yaw, value.speed))
    return Trajectory(float(value.interval), x, y, yaw, speed, value.behaviour)


def command_of(value: Any) -> Command:
    """The command, which need not be a valid one."""
    return Command(float(value.throttle), float(value.brake), bool(value.change_lane))


def event_of(value: Any) -> Event | None:
    """What happened; None where it is of a kind that this version does not know.

    Bags of earlier versions tell neither the kinds of the others nor the blame and the speed of a collision.
    """
    if value.kind not in set(EventKind):
        return None
    kinds = set(ObjectKind)
    impact_speed = float(getattr(value, "impact_speed", math.nan))
    return Event(
        stamp_of(value) * 1e-9,
        EventKind(value.kind),
        value.text,
        tuple(int(number) for number in value.object_id),
        tuple(value.object_name),
        tuple(ObjectKind(kind) if kind in kinds else ObjectKind.UNKNOWN for kind in getattr(value, "object_kind", ())),
        Blame(value.blame) if getattr(value, "blame", None) in set(Blame) else Blame.UNKNOWN,
        impact_speed if math.isfinite(impact_speed) else None,
    )


def stamp_of(value: Any) -> int:
    """The stamp of a message with a header [ns]."""
    return int(value.header.stamp.sec) * 1_000_000_000 + int(value.header.stamp.nanosec)


def floats_of(values: Any) -> Floats:
    """An array of numbers as numpy has it."""
    return np.array(values, dtype=np.float64)
