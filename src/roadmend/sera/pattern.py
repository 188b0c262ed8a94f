"""A failure pattern: what goes wrong again and again, where, with whom and why, and which episodes show it."""

from dataclasses import dataclass

from pydantic import ConfigDict

from roadmend.sera.descriptor import (
    Control,
    Density,
    EgoManoeuvre,
    HazardKind,
    Light,
    OutcomeName,
    ParticipantKind,
    RoadKind,
    Side,
)
from roadmend.world.families import FamilyName
from roadmend.world.scenario import DriverName, Weather

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True, slots=True)
class Where:
    """Place and conditions; None stands for any."""

    __pydantic_config__ = _STRICT

    family: FamilyName | None = None
    road: RoadKind | None = None
    control: Control | None = None
    lanes: int | None = None
    speed_limit: float | None = None  # [m/s]
    density: Density | None = None
    weather: Weather | None = None
    light: Light | None = None


@dataclass(frozen=True, slots=True)
class Who:
    """Whom the ego had to do with; None stands for anybody."""

    __pydantic_config__ = _STRICT

    participant: ParticipantKind | None = None
    side: Side | None = None  # of the ego, at the start
    driver: DriverName | None = None


@dataclass(frozen=True, slots=True)
class Why:
    """What the ego did and what it met; None stands for anything."""

    __pydantic_config__ = _STRICT

    manoeuvre: EgoManoeuvre | None = None  # of the ego
    hazard: HazardKind | None = None
    ego_speed: float | None = None  # [m/s] at the start


@dataclass(frozen=True, slots=True)
class Evidence:
    """One episode that shows the pattern."""

    __pydantic_config__ = _STRICT

    episode: str  # the bag's path, or the scenario's name where there is none
    scenario: str = ""  # its digest, hexadecimal
    time: float | None = None  # [s] of the failure
    note: str = ""


@dataclass(frozen=True, slots=True)
class FailurePattern:
    """A kind of failure. Words and structure say the same; either may say more than the other."""

    __pydantic_config__ = _STRICT

    name: str
    words: str = ""
    what: OutcomeName | None = None
    where: Where = Where()
    who: Who = Who()
    why: Why = Why()
    evidence: tuple[Evidence, ...] = ()
