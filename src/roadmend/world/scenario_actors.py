"""Who shares the road with the ego in a scenario: vehicles with their manoeuvres, and people on foot."""

import itertools
import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from roadmend.world.scenario_fields import Coordinate, EdgeList, Metres, Seconds, Speed, is_false
from roadmend.world.scenario_model import Identifier, ScenarioModel

_APART = 1e-3  # [m] between two points that follow each other

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
    backwards: bool = Field(default=False, exclude_if=is_false, description="the rear goes first")

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
