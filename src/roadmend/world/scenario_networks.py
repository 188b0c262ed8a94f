"""The roads of a scenario: made from a few numbers, or a SUMO network or configuration from a file."""

import itertools
from typing import Annotated, Literal

from pydantic import Field, model_validator

from roadmend.world.scenario_fields import FILE_NAME, Seconds, Speed, is_false, is_none, is_zero
from roadmend.world.scenario_model import Identifier, ScenarioModel

_BEARINGS = 1.0  # [deg] between two arms at least
CENTRE = "centre"  # the junction at which the arms of an intersection meet


class Arm(ScenarioModel):
    """One road that meets the others at an intersection: edges NAME_in (towards it) and NAME_out."""

    name: Identifier
    bearing: float = Field(ge=-360.0, le=360.0, description="[deg] seen from the centre, counter-clockwise from east")
    lanes: int = Field(default=1, ge=1, le=6, description="lanes in each direction")
    lanes_out: int | None = Field(
        default=None, ge=1, le=6, exclude_if=is_none, description="lanes of NAME_out where they are not as many"
    )
    speed_limit: Speed = 13.89
    length: float = Field(default=150.0, ge=20.0, le=5000.0, description="[m]")
    major: bool = Field(default=False, description="has right of way where control is 'priority'")
    median: float = Field(default=0.0, ge=0.0, le=60.0, exclude_if=is_zero, description="[m] between the directions")


class IntersectionNetwork(ScenarioModel):
    """Three to six roads that meet in one point."""

    kind: Literal["intersection"] = "intersection"
    arms: list[Arm] = Field(min_length=3, max_length=6)
    control: Literal["priority", "priority_stop", "right_before_left", "allway_stop", "traffic_light"] = "priority"
    crossings: bool = Field(default=False, description="sidewalks, and zebra crossings on every arm")
    cycle: float = Field(default=40.0, ge=20.0, le=180.0, description="[s] cycle of the traffic light")
    phase: float = Field(
        default=0.0, ge=0.0, le=180.0, exclude_if=is_zero, description="[s] of the cycle that have passed at the start"
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
        exclude_if=is_zero,
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
        default=0.0, ge=0.0, le=60.0, exclude_if=is_zero, description="[m] between the two directions"
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
        exclude_if=is_false,
        description="an ego without a route drives a stretch of what some car drives, drawn by the seed, from a speed "
        "that suits the place; else all of the longest route under way, from standstill",
    )
    content: str | None = Field(
        default=None,
        exclude_if=is_none,
        description="digest of the configuration's files as they were; it tells kept results apart and is not checked",
    )


Network = Annotated[
    IntersectionNetwork | HighwayExitNetwork | OnRampNetwork | OpenRoadNetwork | NetworkFile | SumoConfiguration,
    Field(discriminator="kind"),
]
