"""What stands where it is, beside a road or on it."""

from typing import Literal

from pydantic import Field

from roadmend.world.scenario_model import Identifier, ScenarioModel

ObstacleKind = Literal[
    "tree",
    "pole",
    "sign",
    "barrier",
    "wall",
    "ditch",
    "curb",
    "parked_vehicle",
    "animal",
    "debris",
    "object",
]


class Obstacle(ScenarioModel):
    """Something that stands where it is, beside the road or on it.

    The ego, and vehicles that have left the lanes (drift, follow), can strike it. Whoever SUMO drives along a lane does
    not see it.
    """

    id: Identifier
    kind: ObstacleKind = "object"
    x: float = Field(ge=-100_000.0, le=100_000.0, description="[m] of its middle, in the map frame")
    y: float = Field(ge=-100_000.0, le=100_000.0, description="[m]")
    heading: float = Field(default=0.0, ge=-360.0, le=360.0, description="[deg] of its length, from east to the left")
    length: float = Field(default=0.5, ge=0.05, le=100.0, description="[m]")
    width: float = Field(default=0.5, ge=0.05, le=100.0, description="[m]")
    firm: bool = Field(
        default=True, description="who strikes it stands there from then on; else drives on over it, and it stays"
    )
