"""What a scenario is, in structure and in words, and what policies have made of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Literal, Self, cast, get_args

from pydantic import ConfigDict, Field

from roadmend.core.outcome import EventKind
from roadmend.world.families import FamilyName
from roadmend.world.scenario import Scenario, Weather
from roadmend.world.scenario_actors import DriverName, VehicleKind

RoadKind = Literal["intersection", "tee_junction", "highway_exit", "on_ramp", "road_network"]
Control = Literal["priority", "right_before_left", "allway_stop", "traffic_light"]
EgoManoeuvre = Literal["left_turn", "right_turn", "straight", "exit", "merge", "keep_lane"]
HazardKind = Literal["cut_in", "cut_in_and_brake", "hard_braking", "run_right_of_way", "pedestrian_crossing"]
ParticipantKind = VehicleKind | Literal["pedestrian"]
Side = Literal["ahead", "behind", "left", "right", "oncoming"]
Light = Literal["daytime", "nighttime"]
Density = Literal["light", "medium", "dense"]
OutcomeName = Literal["GOAL", "COLLISION", "TIMEOUT", "OFF_ROUTE", "ABORTED"]
Count = Annotated[int, Field(ge=0)]

PARTICIPANTS: tuple[ParticipantKind, ...] = (*get_args(VehicleKind), "pedestrian")
SUCCESS: OutcomeName = "GOAL"
_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
_MEDIUM_FROM, _DENSE_FROM = 6, 13  # participants

assert set(get_args(OutcomeName)) == {kind.name for kind in EventKind if kind.is_final}


def outcome_name(name: str) -> OutcomeName:
    """The outcome of a name.

    Raises:
        ValueError: there is none.
    """
    for known in get_args(OutcomeName):
        if name == known:
            return cast(OutcomeName, known)
    raise ValueError(f"there is no outcome {name!r}")


@dataclass(frozen=True, slots=True)
class RoadDescriptor:
    """Where the ego drives."""

    __pydantic_config__ = _STRICT

    kind: RoadKind
    lanes: int | None = None  # of the ego's road in its direction
    speed_limit: float | None = None  # [m/s] of the ego's first road
    control: Control | None = None  # of the intersection
    crossings: bool = False  # zebra crossings


@dataclass(frozen=True, slots=True)
class Hazard:
    """What another participant does that the ego must cope with."""

    __pydantic_config__ = _STRICT

    kind: HazardKind
    participant: ParticipantKind
    side: Side | None = None  # of the ego that the participant starts on; None where the road does not tell
    distance: float | None = None  # [m] to the ego at which it begins; None where the time decides


@dataclass(frozen=True, slots=True)
class OutcomeStatistics:
    """What one policy under one repair method has made of the scenario."""

    __pydantic_config__ = _STRICT

    policy: str
    outcomes: Mapping[OutcomeName, Count]  # runs by how they ended
    min_distance: float | None = None  # [m] to anybody, the least of all runs; None where nobody was met
    method: str = "none"

    @property
    def runs(self) -> int:
        """How often it was run."""
        return sum(self.outcomes.values())

    @property
    def failures(self) -> int:
        """Runs that did not reach the goal."""
        return self.runs - self.outcomes.get(SUCCESS, 0)

    def merged(self, other: Self) -> Self:
        """Both counts together; the two are of the same policy and method."""
        distances = [each for each in (self.min_distance, other.min_distance) if each is not None]
        names = sorted({*self.outcomes, *other.outcomes})
        counts = {name: self.outcomes.get(name, 0) + other.outcomes.get(name, 0) for name in names}
        return replace(self, outcomes=counts, min_distance=min(distances, default=None))


@dataclass(frozen=True, slots=True)
class Descriptor:
    """A scenario as a person would describe it: the road, the task, the others, what goes wrong, and the conditions."""

    __pydantic_config__ = _STRICT

    road: RoadDescriptor
    manoeuvre: EgoManoeuvre | None  # of the ego; None where the road does not tell
    participants: Mapping[ParticipantKind, Count]  # others by kind
    drivers: Mapping[DriverName, Count]  # others by habit
    hazards: tuple[Hazard, ...]
    weather: Weather
    light: Light
    friction: float  # tyre-road coefficient
    sensing_range: float  # [m]
    ego_speed: float  # [m/s] at the start
    family: FamilyName | None = None
    outcomes: tuple[OutcomeStatistics, ...] = ()  # one for each policy and method
    notes: str = ""  # free words: the text of a report, of a final event

    @property
    def density(self) -> Density:
        """How much traffic there is, people on foot included."""
        count = sum(self.participants.values())
        return "dense" if count >= _DENSE_FROM else "medium" if count >= _MEDIUM_FROM else "light"

    @property
    def difficulty(self) -> float | None:
        """Share of all runs that did not reach the goal; None before the first run."""
        runs = sum(each.runs for each in self.outcomes)
        return sum(each.failures for each in self.outcomes) / runs if runs else None

    def with_outcomes(self, found: tuple[OutcomeStatistics, ...]) -> Self:
        """Add what was found to what is known."""
        known = {(each.policy, each.method): each for each in self.outcomes}
        for each in found:
            key = each.policy, each.method
            known[key] = known[key].merged(each) if key in known else each
        return replace(self, outcomes=tuple(known[key] for key in sorted(known)))


@dataclass(frozen=True, slots=True)
class BankEntry:
    """A scenario of the bank. One without content can be found, but not run."""

    digest: str  # of the scenario, hexadecimal
    name: str
    origin: str  # where it came from: a family, a corpus, a file
    descriptor: Descriptor
    scenario: Scenario | None = None
