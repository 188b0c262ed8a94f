"""The scenario model: everything that decides how an episode runs, readable and writable as YAML."""

import hashlib
import itertools
import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario_model import Identifier, ScenarioModel

FORMAT: Literal["roadmend-scenario/1"] = "roadmend-scenario/1"
_BEARINGS = 1.0  # [deg] between two arms at least
_APART = 1e-3  # [m] between two points that follow each other
FILE_NAME = r"^[^\x00]+$"
CENTRE = "centre"  # the junction at which the arms of an intersection meet

Metres = Annotated[float, Field(ge=0.0, le=100_000.0, allow_inf_nan=False)]
Seconds = Annotated[float, Field(ge=0.0, le=86_400.0, allow_inf_nan=False)]
Speed = Annotated[float, Field(ge=0.0, le=70.0, allow_inf_nan=False, description="[m/s]")]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False, strict=True, description="[m]")]
EdgeList = Annotated[list[str], Field(min_length=1, description="road network edges in driving order")]

VehicleKind = Literal[
    "car",
    "suv",
    "minivan",
    "pickup",
    "truck",
    "semi_truck",
    "bus",
    "motorcycle",
    "bicycle",
]
DriverName = Literal["careful", "normal", "aggressive", "reckless"]
Weather = Literal["clear", "sunny", "cloudy", "overcast", "windy", "rainy", "foggy", "snowy"]


def _is_none(value: object) -> bool:
    return value is None


def _is_zero(value: object) -> bool:
    return value == 0.0


def _is_false(value: object) -> bool:
    return value is False


def _is_empty(value: object) -> bool:
    return value == []


class Arm(ScenarioModel):
    """One road that meets the others at an intersection: edges NAME_in (towards it) and NAME_out."""

    name: Identifier
    bearing: float = Field(ge=-360.0, le=360.0, description="[deg] seen from the centre, counter-clockwise from east")
    lanes: int = Field(default=1, ge=1, le=6, description="lanes in each direction")
    lanes_out: int | None = Field(
        default=None, ge=1, le=6, exclude_if=_is_none, description="lanes of NAME_out where they are not as many"
    )
    speed_limit: Speed = 13.89
    length: float = Field(default=150.0, ge=20.0, le=5000.0, description="[m]")
    major: bool = Field(default=False, description="has right of way where control is 'priority'")
    median: float = Field(default=0.0, ge=0.0, le=60.0, exclude_if=_is_zero, description="[m] between the directions")


class IntersectionNetwork(ScenarioModel):
    """Three to six roads that meet in one point."""

    kind: Literal["intersection"] = "intersection"
    arms: list[Arm] = Field(min_length=3, max_length=6)
    control: Literal["priority", "priority_stop", "right_before_left", "allway_stop", "traffic_light"] = "priority"
    crossings: bool = Field(default=False, description="sidewalks, and zebra crossings on every arm")
    cycle: float = Field(default=40.0, ge=20.0, le=180.0, description="[s] cycle of the traffic light")
    phase: float = Field(
        default=0.0, ge=0.0, le=180.0, exclude_if=_is_zero, description="[s] of the cycle that have passed at the start"
    )

    @model_validator(mode="after")
    def _names_of_their_own(self) -> "IntersectionNetwork":
        seen = {CENTRE}
        for arm in self.arms:
            if arm.name in seen:
                raise ValueError(f"arm {arm.name!r} has a name that is taken, by another arm or by the junction itself")
            seen.add(arm.name)
        bearings = sorted((arm.bearing % 360.0, arm.name) for arm in self.arms)
        for (before, one), (after, other) in itertools.pairwise([*bearings, (bearings[0][0] + 360.0, bearings[0][1])]):
            if after - before < _BEARINGS:
                raise ValueError(f"arms {one!r} and {other!r} lie one upon the other; give them other bearings")
        return self


class HighwayExitNetwork(ScenarioModel):
    """A highway with a deceleration lane: edges approach, diverge, mainline and ramp."""

    kind: Literal["highway_exit"] = "highway_exit"
    lanes: int = Field(default=3, ge=1, le=6)
    speed_limit: Speed = 30.0
    ramp_speed_limit: Speed = 17.0
    approach_length: float = Field(default=350.0, ge=50.0, le=5000.0, description="[m]")
    lane_length: float = Field(default=200.0, ge=50.0, le=1000.0, description="[m] deceleration lane")
    ramp_length: float = Field(default=150.0, ge=50.0, le=2000.0, description="[m]")


class OnRampNetwork(ScenarioModel):
    """A highway with an acceleration lane: edges approach, ramp, merge and mainline."""

    kind: Literal["on_ramp"] = "on_ramp"
    lanes: int = Field(default=2, ge=1, le=6)
    speed_limit: Speed = 27.0
    ramp_speed_limit: Speed = 17.0
    approach_length: float = Field(default=300.0, ge=50.0, le=5000.0, description="[m]")
    lane_length: float = Field(default=200.0, ge=50.0, le=1000.0, description="[m] acceleration lane")
    ramp_length: float = Field(default=150.0, ge=50.0, le=2000.0, description="[m]")
    bearing: float = Field(
        default=0.0,
        ge=-360.0,
        le=360.0,
        exclude_if=_is_zero,
        description="[deg] of the highway, eastbound if not given",
    )


class OpenRoadNetwork(ScenarioModel):
    """One road between two ends: edge forward and, where it has lanes the other way, edge backward."""

    kind: Literal["road"] = "road"
    lanes: int = Field(default=1, ge=1, le=12)
    backward_lanes: int = Field(default=1, ge=0, le=12)
    bearing: float = Field(default=0.0, ge=-360.0, le=360.0, description="[deg] of edge forward where it begins")
    bend: float = Field(default=0.0, ge=-170.0, le=170.0, description="[deg] turn half way along, left is positive")
    radius: float = Field(default=100.0, ge=25.0, le=2000.0, description="[m] of the bend")
    length: float = Field(default=400.0, ge=100.0, le=5000.0, description="[m] without the bend")
    speed_limit: Speed = 22.35
    backward_speed_limit: Speed = 22.35
    median: float = Field(
        default=0.0, ge=0.0, le=60.0, exclude_if=_is_zero, description="[m] between the two directions"
    )


class NetworkFile(ScenarioModel):
    """Any SUMO network."""

    kind: Literal["file"] = "file"
    path: str = Field(pattern=FILE_NAME, description="SUMO .net.xml file; relative paths start at the scenario file")


class SumoConfiguration(ScenarioModel):
    """A whole SUMO configuration with its own network and traffic; roadmend adds the ego."""

    kind: Literal["sumocfg"] = "sumocfg"
    path: str = Field(pattern=FILE_NAME, description="SUMO .sumocfg file; relative paths start at the scenario file")
    warm_up: Seconds = Field(default=600.0, description="[s] of traffic before the ego enters")
    draw: bool = Field(
        default=False,
        exclude_if=_is_false,
        description="an ego without a route drives a stretch of what some car drives, drawn by the seed, from a speed "
        "that suits the place; else all of the longest route under way, from standstill",
    )
    content: str | None = Field(
        default=None,
        exclude_if=_is_none,
        description="digest of the configuration's files as they were; it tells kept results apart and is not checked",
    )


Network = Annotated[
    IntersectionNetwork | HighwayExitNetwork | OnRampNetwork | OpenRoadNetwork | NetworkFile | SumoConfiguration,
    Field(discriminator="kind"),
]


class Ego(ScenarioModel):
    """Task and size of the vehicle under test."""

    route: list[str] = Field(
        default=[], description="edges in driving order; with a SUMO configuration, none takes a route from its traffic"
    )
    lane: int = Field(default=0, ge=0, le=20, description="first lane, 0 is the rightmost for vehicles")
    position: Metres = Field(default=5.0, description="[m] of the centre along the first edge at the start")
    speed: Speed = Field(default=0.0, description="[m/s] at the start")
    goal: Metres | None = Field(
        default=None, description="[m] along the last edge; shortly before its end if not given"
    )
    length: float = Field(default=4.7, ge=1.0, le=20.0, description="[m]")
    width: float = Field(default=1.85, ge=0.5, le=3.0, description="[m]")


class Trigger(ScenarioModel):
    """When a manoeuvre begins: at a time, or when the ego comes near from behind. Exactly one of the two."""

    time: Seconds | None = Field(default=None, description="[s] since the start of the episode")
    ego_distance: float | None = Field(
        default=None, ge=0.0, le=40.0, description="[m] between the centres, the actor ahead of the ego"
    )

    @model_validator(mode="after")
    def _one_of_two(self) -> "Trigger":
        if (self.time is None) == (self.ego_distance is None):
            raise ValueError("give either time or ego_distance")
        return self


class Brake(ScenarioModel):
    """Slow down hard, hold, then drive on."""

    action: Literal["brake"] = "brake"
    when: Trigger
    speed: Speed = Field(default=0.0, description="[m/s] to slow down to")
    deceleration: float = Field(default=6.0, gt=0.1, le=9.0, description="[m/s2]")
    hold: Seconds = Field(default=3.0, description="[s] at the low speed")


class CutIn(ScenarioModel):
    """Change lane without regard for others."""

    action: Literal["cut_in"] = "cut_in"
    when: Trigger
    direction: Literal["left", "right", "ego"] = Field(description="ego: towards the ego's lane")


class RunRightOfWay(ScenarioModel):
    """Drive on at junctions, red lights too, as if nobody else were there.

    The driver stays as lively as in haste: accelerates by 4 m/s2 or more from then on.
    """

    action: Literal["run"] = "run"
    when: Trigger
    haste: float = Field(default=1.0, ge=0.5, le=2.0, description="factor on the driver's wanted speed meanwhile")
    hold: Seconds = Field(default=10.0, description="[s] how long")


class Heedless(ScenarioModel):
    """Hold a speed as if nobody else were there: no braking for those ahead, no right of way, no red light."""

    action: Literal["heedless"] = "heedless"
    when: Trigger
    speed: Speed = Field(description="[m/s] to hold")


class Drift(ScenarioModel):
    """Leave the lane sideways, across the centre line too, at the speed of the moment, and stay beside it.

    It takes longer than told where the tyres could not do it in that time.
    """

    action: Literal["drift"] = "drift"
    when: Trigger
    offset: float = Field(ge=-40.0, le=40.0, description="[m] sideways, left is positive")
    over: float = Field(default=2.0, ge=0.3, le=20.0, description="[s] that it takes to get there")


class Follow(ScenarioModel):
    """Leave the lanes and drive along a line of one's own, forwards or backwards; stand where it ends."""

    action: Literal["follow"] = "follow"
    when: Trigger
    points: list[tuple[Coordinate, Coordinate]] = Field(
        min_length=2, max_length=500, description="[m] in the map frame, none where the one before it is"
    )
    speed: Speed = Field(description="[m/s] to go at")
    backwards: bool = Field(default=False, exclude_if=_is_false, description="the rear goes first")

    @model_validator(mode="after")
    def _comes_on(self) -> "Follow":
        for place, (before, after) in enumerate(itertools.pairwise(self.points)):
            if math.dist(before, after) < _APART:
                raise ValueError(f"points[{place}] and points[{place + 1}] are one place; leave one of them out")
        return self


Manoeuvre = Annotated[Brake | CutIn | RunRightOfWay | Heedless | Drift | Follow, Field(discriminator="action")]


class Vehicle(ScenarioModel):
    """A vehicle that shares the road with the ego."""

    type: Literal["vehicle"] = "vehicle"
    id: Identifier
    kind: VehicleKind = "car"
    driver: DriverName = "normal"
    route: EdgeList
    depart: Seconds = 0.0
    lane: int = Field(default=0, ge=0, le=20)
    position: Metres = Field(default=0.0, description="[m] of the front bumper along the first edge")
    speed: Speed | None = Field(
        default=None,
        description="[m/s] at departure, at most what the driver wants to go there; that speed if not given",
    )
    speed_factor: float | None = Field(default=None, ge=0.3, le=2.0, description="of the speed limit; the driver's")
    manoeuvres: list[Manoeuvre] = Field(default=[])


class Pedestrian(ScenarioModel):
    """A person on foot, walking from the first edge of the route to the last along sidewalks and crossings."""

    type: Literal["pedestrian"] = "pedestrian"
    id: Identifier
    driver: DriverName = "normal"
    route: EdgeList
    depart: Seconds = 0.0
    position: Metres = Field(default=0.0, description="[m] along the first edge")
    speed: float = Field(default=1.3, ge=0.2, le=6.0, description="[m/s]")


Actor = Annotated[Vehicle | Pedestrian, Field(discriminator="type")]

# Tyre-road friction and how far objects are seen [m], by weather; published ranges for passenger tyres on asphalt.
_FRICTION: dict[str, float] = {
    "clear": 0.9,
    "sunny": 0.9,
    "cloudy": 0.9,
    "overcast": 0.85,
    "windy": 0.85,
    "rainy": 0.6,
    "foggy": 0.7,
    "snowy": 0.35,
}
_SENSING: dict[str, float] = {
    "clear": 150.0,
    "sunny": 150.0,
    "cloudy": 150.0,
    "overcast": 150.0,
    "windy": 150.0,
    "rainy": 110.0,
    "foggy": 60.0,
    "snowy": 90.0,
}
_NIGHT = 0.8  # share of the daytime sensing range that is left at night


class Environment(ScenarioModel):
    """Weather and light, and what follows from them."""

    weather: Weather = "clear"
    time_of_day: Literal["daytime", "nighttime"] = "daytime"
    friction: float | None = Field(default=None, gt=0.05, le=1.2, description="tyre-road friction; the weather's")
    sensing_range: float | None = Field(
        default=None, gt=5.0, le=100_000.0, description="[m]; the weather's and light's"
    )

    @property
    def effective_friction(self) -> float:
        """Tyre-road friction coefficient."""
        return self.friction if self.friction is not None else _FRICTION[self.weather]

    @property
    def limits_sight(self) -> bool:
        """Whether it says how far participants are seen: by the range itself, the weather or the light."""
        return self.sensing_range is not None or (self.weather, self.time_of_day) != ("clear", "daytime")

    @property
    def effective_range(self) -> float:
        """How far participants are seen [m]."""
        if self.sensing_range is not None:
            return self.sensing_range
        return _SENSING[self.weather] * (_NIGHT if self.time_of_day == "nighttime" else 1.0)


class ReportOrigin(ScenarioModel):
    """What a scenario was made from. It says where the values come from and changes nothing in how it runs."""

    report: str = Field(description="name of the crash report")
    vehicle: int | None = Field(
        default=None,
        ge=1,
        exclude_if=_is_none,
        description="number of the report's vehicle that the ego takes the place of; none where it looks on",
    )
    sampled: dict[str, float | int | str | bool] = Field(description="what the report leaves open, as it was drawn")
    adapted: list[str] = Field(default=[], description="where the report could not be followed to the letter")


class Scenario(ScenarioModel):
    """One episode, complete: the same scenario, policy and repair method give the same trajectories, bit for bit."""

    format: Literal["roadmend-scenario/1"] = FORMAT
    name: Identifier
    family: Identifier | None = None
    seed: int = Field(default=0, ge=0, le=2_147_483_647, strict=True)
    time_limit: float = Field(default=60.0, gt=0.0, le=86_400.0, allow_inf_nan=False, description="[s]")
    network: Network
    ego: Ego
    actors: list[Actor] = Field(default=[])
    obstacles: list[Obstacle] = Field(default=[], exclude_if=_is_empty)
    environment: Environment = Environment()
    origin: ReportOrigin | None = Field(default=None, exclude_if=_is_none)

    @model_validator(mode="after")
    def _unique_ids(self) -> "Scenario":
        seen: set[str] = {"ego"}
        for one in (*self.actors, *self.obstacles):
            if one.id in seen:
                raise ValueError(f"{'obstacle' if isinstance(one, Obstacle) else 'actor'} id {one.id!r} is used twice")
            seen.add(one.id)
        return self

    @model_validator(mode="after")
    def _nobody_joins_users_traffic(self) -> "Scenario":
        if self.actors and isinstance(self.network, SumoConfiguration):
            raise ValueError(
                "there are actors in a SUMO configuration, which has its own traffic; write them into that"
            )
        return self

    @property
    def digest(self) -> str:
        """SHA-256 of what decides how the scenario runs, hexadecimal."""
        return hashlib.sha256(self.model_dump_json(exclude={"origin"}).encode()).hexdigest()
