"""Directions of the scenario language as headings in the map frame: counter-clockwise from east."""

import math

from roadmend.safe.dsl import Action, Compass, Position

HEADING: dict[Position, int] = {  # [deg]
    Position.W2E: 0,
    Position.S2N: 90,
    Position.E2W: 180,
    Position.N2S: 270,
    Position.MAIN_ROAD: 0,
    Position.ON_RAMP: 0,
}
TURN: dict[Action, int] = {Action.MOVE_FORWARD: 0, Action.TURN_LEFT: 90, Action.TURN_RIGHT: -90}  # [deg]
SIDE_AT: dict[int, Compass] = {0: Compass.EAST, 90: Compass.NORTH, 180: Compass.WEST, 270: Compass.SOUTH}
BEARING: dict[Compass, int] = {side: bearing for bearing, side in SIDE_AT.items()}  # [deg] seen from the centre


def wrap_degrees(angle: float) -> float:
    """The same angle from -180 to 180 [deg]; -180 counts as 180."""
    wrapped = math.remainder(angle, 360.0)
    return 180.0 if wrapped == -180.0 else wrapped


def heading_of(begin: tuple[float, float], end: tuple[float, float], seen_from: float = 0.0) -> float:
    """Heading from one point to another, relative to another heading [deg]."""
    return wrap_degrees(math.degrees(math.atan2(end[1] - begin[1], end[0] - begin[0])) - seen_from)
