"""The scenario model: everything that decides how an episode runs, readable and writable as YAML."""

import hashlib
from typing import Literal

from pydantic import Field, model_validator

from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario_actors import Actor
from roadmend.world.scenario_fields import Metres, Speed, is_empty, is_none
from roadmend.world.scenario_model import Identifier, ScenarioModel
from roadmend.world.scenario_networks import Network, SumoConfiguration

FORMAT: Literal["roadmend-scenario/1"] = "roadmend-scenario/1"

Weather = Literal["clear", "sunny", "cloudy", "overcast", "windy", "rainy", "foggy", "snowy"]


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
        exclude_if=is_none,
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
    obstacles: list[Obstacle] = Field(default=[], exclude_if=is_empty)
    environment: Environment = Environment()
    origin: ReportOrigin | None = Field(default=None, exclude_if=is_none)

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
