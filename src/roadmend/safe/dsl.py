"""The scenario language of SAFE (listing 1 of the paper): what happened, as far as a crash report says it.

A field that the report leaves open is None. Three optional parts go beyond the paper's grammar: a vehicle's manoeuvre in
more words than the three actions have, the collisions in their order, and what a vehicle struck that is none. Whatever
else a user wants to carry along goes into ``extras``, under names that start with ``x-``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

Extras = Mapping[str, Any]  # what JSON can hold
Coordinates = tuple[tuple[float, float], ...]  # [m] x, y in the map frame, in the order of travel

EXTRA_PREFIX = "x-"
MAX_LANES = 24
MAX_SPEED_LIMIT = 100  # [mph]
KM_PER_MILE = 1.609344


class RoadType(StrEnum):
    """Shape of the road where the vehicles first collide."""

    STRAIGHT = "Straight"
    CURVE = "Curve"
    INTERSECTION = "Intersection"
    T_INTERSECTION = "T-intersection"
    MERGING = "Merging"


class Compass(StrEnum):
    """Side of a T-intersection on which the ending road, its stem, lies."""

    NORTH = "North"
    SOUTH = "South"
    EAST = "East"
    WEST = "West"


class DslModel(StrEnum):
    """Body class of a vehicle."""

    SEDAN = "Sedan"
    SUV = "SUV"
    MINIVAN = "Minivan"
    PICKUP = "Pickup"
    SEMI_TRUCK = "Semi Truck"


class Position(StrEnum):
    """Direction of travel before the crash (W2E heads east), or the road a vehicle comes from where roads merge."""

    W2E = "W2E"
    E2W = "E2W"
    S2N = "S2N"
    N2S = "N2S"
    MAIN_ROAD = "Main road"
    ON_RAMP = "On-ramp"


class Action(StrEnum):
    """What a vehicle does, in the words of the paper's grammar."""

    MOVE_FORWARD = "Move Forward"
    TURN_LEFT = "Turn Left"
    TURN_RIGHT = "Turn Right"


class Manoeuvre(StrEnum):
    """What a vehicle does, in more words: all but the turns are Move Forward to the paper's grammar."""

    MOVE_FORWARD = "Move Forward"
    TURN_LEFT = "Turn Left"
    TURN_RIGHT = "Turn Right"
    ENTER_THE_WRONG_WAY = "Enter the Wrong Way"
    CHANGING_LANE = "Changing Lane"
    STOP = "Stop"
    MERGE = "Merge"
    OVERTAKE = "Overtake"
    U_TURN = "U-turn"
    REVERSE = "Reverse"
    PARKED = "Parked"
    LEAVE_DRIVEWAY = "Leave a Driveway"
    RUN_OFF = "Run off the Road"


STANDING = frozenset({Manoeuvre.STOP, Manoeuvre.PARKED})
SIDEWAYS = frozenset({Manoeuvre.CHANGING_LANE, Manoeuvre.MERGE, Manoeuvre.OVERTAKE})  # into the next lane
CROSSING_OVER = frozenset({Manoeuvre.ENTER_THE_WRONG_WAY, Manoeuvre.OVERTAKE})  # onto the half for the others


class Time(StrEnum):
    """Time of day; dawn and dusk have light and are Daytime."""

    DAYTIME = "Daytime"
    NIGHTTIME = "Nighttime"


class Weather(StrEnum):
    """The weather, one word."""

    SUNNY = "Sunny"
    CLOUDY = "Cloudy"
    OVERCAST = "Overcast"
    RAINY = "Rainy"
    SNOWY = "Snowy"
    FOGGY = "Foggy"
    WINDY = "Windy"
    CLEAR = "Clear"


class Control(StrEnum):
    """What orders the traffic where the vehicles meet."""

    STOP_SIGN = "Stop sign"
    YIELD_SIGN = "Yield sign"
    SIGNAL = "Signal"
    NONE = "None"


class Side(StrEnum):
    """Side of a vehicle that takes part in a collision."""

    FRONT = "Front"
    REAR = "Rear"
    LEFT = "Left"
    RIGHT = "Right"


class StruckObject(StrEnum):
    """What a vehicle strikes that is none: it stands beside the road, but for the last two."""

    TREE = "Tree"
    POLE = "Pole"
    SIGN = "Sign"
    BARRIER = "Barrier"
    WALL = "Wall"
    DITCH = "Ditch"
    CURB = "Curb"
    PARKED_TRAILER = "Parked Trailer"
    OTHER = "Other"
    ANIMAL = "Animal"
    DEBRIS = "Debris"


ON_THE_ROADWAY = frozenset({StruckObject.ANIMAL, StruckObject.DEBRIS})


@dataclass(frozen=True, slots=True)
class DescribedRoadNetwork:
    """The road.

    Attributes:
        road_type: its shape.
        lanes: of the road in all, both directions together; at a junction those of the larger road.
        stem: where the stem of a T-intersection lies; None for every other road type.
        is_divided: whether something keeps the two directions apart, where the report says.
        bend: the side to which a curve bends, as the first vehicle sees it.
        control: what orders the traffic, where the report says.
    """

    road_type: RoadType | None
    lanes: int | None
    stem: Compass | None = None
    is_divided: bool | None = None
    bend: Side | None = None
    control: Control | None = None

    def __post_init__(self) -> None:
        if self.lanes is not None and not 1 <= self.lanes <= MAX_LANES:
            raise ValueError(f"num_lanes is {self.lanes}, not from 1 to {MAX_LANES}")
        if self.bend not in {None, Side.LEFT, Side.RIGHT}:
            raise ValueError(f"bend is {self.bend}, but a road bends to the Left or the Right")
        if self.stem is not None and self.road_type is not RoadType.T_INTERSECTION:
            raise ValueError(f"stem_direction is {self.stem}, but only a T-intersection has a stem")


@dataclass(frozen=True, slots=True)
class DescribedVehicle:
    """One vehicle that took part; its number is its place among the vehicles, from 1.

    Attributes:
        model: body class.
        initial_position: where it comes from.
        action: what it does, or the points that it passes instead.
        speed_limit_mph: the limit posted for it [mph], not its speed.
        manoeuvre: what it does in more words than an action has, where known.
        extras: further fields.
    """

    model: DslModel | None
    initial_position: Position | None
    action: Action | Coordinates | None
    speed_limit_mph: float | None
    manoeuvre: Manoeuvre | None = None
    extras: Extras = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if self.speed_limit_mph is not None and not 0 < self.speed_limit_mph <= MAX_SPEED_LIMIT:
            raise ValueError(f"speed_limit_mph is {self.speed_limit_mph}, not above 0 and at most {MAX_SPEED_LIMIT}")
        if isinstance(self.action, tuple) and len(self.action) < 2:
            raise ValueError("action has fewer than two points, which make no way to go")
        _check_extras(self.extras)


@dataclass(frozen=True, slots=True)
class DescribedCollision:
    """Two vehicles touch.

    Attributes:
        striking: number of the vehicle that runs into the other one, from 1.
        struck: number of the other one.
        striking_side: what the first one hits with, where known.
        struck_side: where the other one is hit, where known.
    """

    striking: int
    struck: int
    striking_side: Side | None = None
    struck_side: Side | None = None

    def __post_init__(self) -> None:
        if self.striking == self.struck:
            raise ValueError(f"striking and struck are both {self.striking}: a vehicle cannot collide with itself")


@dataclass(frozen=True, slots=True)
class DescribedImpact:
    """A vehicle strikes something that is no vehicle.

    Attributes:
        striking: number of the vehicle, from 1.
        object: what it strikes.
        striking_side: what it hits with.
        roadside: the side of the road, as the vehicle goes, on which that stands; None for what is on the roadway.
    """

    striking: int
    object: StruckObject | None = None
    striking_side: Side | None = None
    roadside: Side | None = None

    def __post_init__(self) -> None:
        if self.roadside not in {None, Side.LEFT, Side.RIGHT}:
            raise ValueError(f"roadside is {self.roadside}, but a road has a Left and a Right one")


@dataclass(frozen=True, slots=True)
class DescribedEnvironment:
    """Light and weather."""

    time: Time | None
    weather: Weather | None
    extras: Extras = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        _check_extras(self.extras)


@dataclass(frozen=True, slots=True)
class CrashScenario:
    """What a crash report says happened.

    Attributes:
        road: the road network.
        vehicles: those in contact, at least one, in the order of the report's numbers.
        environment: light and weather.
        collisions: in the order in which they happened; empty where the report does not say.
        impacts: with what is no vehicle, in the order in which they happened.
        extras: further fields.
    """

    road: DescribedRoadNetwork
    vehicles: tuple[DescribedVehicle, ...]
    environment: DescribedEnvironment
    collisions: tuple[DescribedCollision, ...] = ()
    impacts: tuple[DescribedImpact, ...] = ()
    extras: Extras = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if not self.vehicles:
            raise ValueError("vehicles is empty: a crash needs at least one")
        merging = self.road.road_type is RoadType.MERGING
        for index, vehicle in enumerate(self.vehicles):
            on_merge = vehicle.initial_position in {Position.MAIN_ROAD, Position.ON_RAMP}
            if vehicle.initial_position is not None and on_merge != merging:
                raise ValueError(
                    f"vehicles[{index}].initial_position is {vehicle.initial_position}, which a road of type "
                    f"{self.road.road_type} does not have"
                )
        named = [("collisions", number) for each in self.collisions for number in (each.striking, each.struck)]
        for part, number in (*named, *(("impacts", each.striking) for each in self.impacts)):
            if not 1 <= number <= len(self.vehicles):
                raise ValueError(f"{part} name vehicle {number}, there are {len(self.vehicles)}")
        _check_extras(self.extras)


def _check_extras(extras: Extras) -> None:
    for name in extras:
        if not is_extra_name(name):
            raise ValueError(f"{name!r} is no field of the language; fields of your own start with {EXTRA_PREFIX}")


def is_extra_name(name: str) -> bool:
    """Whether a field of a user's own may be called so: it has the prefix, and fits into a line of the text form."""
    is_one_line = name.isprintable() and name == name.strip() and not {*name} & {*"<>"}
    return name.startswith(EXTRA_PREFIX) and is_one_line
