"""Colours and heights of what is drawn, shared by the pictures and the live markers.

The hues are those of Okabe and Ito, which people with any common colour blindness can tell apart.
"""

from roadmend.core.repair import RepairStatus
from roadmend.core.route import RightOfWay
from roadmend.core.scene import ObjectKind, Signal

KIND_COLOUR: dict[ObjectKind, str] = {
    ObjectKind.UNKNOWN: "#9aa0a6",
    ObjectKind.CAR: "#56b4e9",
    ObjectKind.TRUCK: "#0072b2",
    ObjectKind.BUS: "#cc79a7",
    ObjectKind.MOTORCYCLE: "#a6761d",
    ObjectKind.BICYCLE: "#d3ae6b",
    ObjectKind.PEDESTRIAN: "#f0e442",
}

KIND_HEIGHT: dict[ObjectKind, float] = {  # [m]
    ObjectKind.UNKNOWN: 1.5,
    ObjectKind.CAR: 1.5,
    ObjectKind.TRUCK: 3.4,
    ObjectKind.BUS: 3.1,
    ObjectKind.MOTORCYCLE: 1.4,
    ObjectKind.BICYCLE: 1.7,
    ObjectKind.PEDESTRIAN: 1.75,
}
EGO_HEIGHT = 1.5  # [m]

STATUS_COLOUR: dict[RepairStatus, str] = {
    RepairStatus.PASS: "#009e73",
    RepairStatus.REPAIRED: "#e69f00",
    RepairStatus.STARTING: "#9aa0a6",
    RepairStatus.STALE_COMMAND: "#aa3377",
    RepairStatus.STALE_OBJECTS: "#aa3377",
    RepairStatus.INVALID_COMMAND: "#cc79a7",
    RepairStatus.INVALID_OBJECTS: "#cc79a7",
    RepairStatus.RESET: "#9aa0a6",
    RepairStatus.MODEL_FAULT: "#882255",
}

SILENT_COLOUR = "#6b7280"  # no word of the repair node

RULE_COLOUR: dict[RightOfWay, str] = {
    RightOfWay.PRIORITY: "#009e73",
    RightOfWay.YIELD: "#e69f00",
    RightOfWay.STOP: "#d55e00",
    RightOfWay.SIGNAL: "#0072b2",
    RightOfWay.CROSSING: "#cc79a7",
}

SIGNAL_COLOUR: dict[Signal, str] = {
    Signal.GREEN: "#00c27a",
    Signal.YELLOW: "#f0e442",
    Signal.RED: "#e0301e",
    Signal.OFF: "#6b7280",
}

TRIGGER_COLOUR = "#d81b1b"  # whoever made the method step in
PLAN_COLOUR = "#7b3fe4"  # the policy's planned trajectory
ROUTE_COLOUR = "#0072b2"
WINDOW_COLOUR = "#e69f00"  # where a lane change may begin
GOAL_COLOUR = "#009e73"


def kind_of(code: int) -> ObjectKind:
    """The kind with this number; UNKNOWN for a number that has no name."""
    return ObjectKind(code) if code in KIND_COLOUR else ObjectKind.UNKNOWN


def status_of(code: int) -> RepairStatus:
    """The repair status with this number; MODEL_FAULT for a number that has no name."""
    return RepairStatus(code) if code in STATUS_COLOUR else RepairStatus.MODEL_FAULT


def signal_of(code: int) -> Signal:
    """The signal with this number; OFF for a number that has no name."""
    return Signal(code) if code in SIGNAL_COLOUR else Signal.OFF


VEHICLE_COLOURS = ("#c41e96", "#006edc", "#148c3c", "#d26e00", "#7b3fe4", "#8a6d00")  # of a crash's vehicles, from 1
