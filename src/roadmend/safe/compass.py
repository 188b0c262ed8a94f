"""Directions of the scenario language: where they lead, how they lie to each other, and as headings in the map frame."""

import math

from roadmend.safe.dsl import Action, Compass, Position, Side

DIRECTIONS = (Position.W2E, Position.S2N, Position.E2W, Position.N2S)  # each to the left of the one before
NORTH_SOUTH = frozenset({Position.N2S, Position.S2N})
TOWARDS: dict[Position, Compass] = {  # that a vehicle drives to
    Position.W2E: Compass.EAST,
    Position.E2W: Compass.WEST,
    Position.S2N: Compass.NORTH,
    Position.N2S: Compass.SOUTH,
}
BOUND: dict[str, Position] = {side.lower(): position for position, side in TOWARDS.items()}  # by a word: "north"
_TO_THE_LEFT = dict(zip(DIRECTIONS, (*DIRECTIONS[1:], DIRECTIONS[0]), strict=True))
_TO_THE_RIGHT = {left: straight for straight, left in _TO_THE_LEFT.items()}

HEADING: dict[Position, int] = {  # [deg] counter-clockwise from east
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


def turned(position: Position, side: Side | None) -> Position:
    """The direction after a turn to the left or right, or straight on."""
    if side is None:
        return position
    return _TO_THE_LEFT[position] if side is Side.LEFT else _TO_THE_RIGHT[position]


def opposite(position: Position) -> Position:
    """The direction of those who come towards it."""
    return _TO_THE_LEFT[_TO_THE_LEFT[position]]


def origin_of(position: Position) -> Compass:
    """The side that a vehicle comes from."""
    return TOWARDS[opposite(position)]


def wrap_degrees(angle: float) -> float:
    """The same angle from -180 to 180 [deg]; -180 counts as 180."""
    wrapped = math.remainder(angle, 360.0)
    return 180.0 if wrapped == -180.0 else wrapped


def heading_of(begin: tuple[float, float], end: tuple[float, float], seen_from: float = 0.0) -> float:
    """Heading from one point to another, relative to another heading [deg]."""
    return wrap_degrees(math.degrees(math.atan2(end[1] - begin[1], end[0] - begin[0])) - seen_from)
