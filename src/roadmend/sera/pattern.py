"""A failure pattern: what goes wrong again and again, where, with whom and why, and which episodes show it."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter, ValidationError

from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json
from roadmend.core.settings import describe
from roadmend.core.yaml_file import read_yaml
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
from roadmend.world.scenario import Weather
from roadmend.world.scenario_actors import DriverName

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
class PatternEvidence:
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
    evidence: tuple[PatternEvidence, ...] = ()


PATTERNS: TypeAdapter[list[FailurePattern]] = TypeAdapter(list[FailurePattern])
_SUFFIXES = (".json", ".yaml", ".yml")
_REMEDY = "give a list of patterns with name, words, what, where, who and why"


def read_patterns(given: str) -> list[FailurePattern]:
    """Patterns from a JSON or YAML file that holds one or a list of them, or one from words.

    Raises:
        InputError: the file is missing, cannot be parsed, or a field of it is unusable; or there are no words.
    """
    path = Path(given)
    if path.suffix.lower() not in _SUFFIXES:
        if not given.strip():
            raise InputError("pattern", "is empty", "give a file or some words, as 'cut-in at an exit in rain'")
        return [FailurePattern(name=given, words=given)]
    # YAML refuses the halves that JSON escapes a character beyond U+FFFF by.
    content = read_json(path, mend=_REMEDY) if path.suffix.lower() == ".json" else read_yaml(path, _REMEDY)
    patterns = parse_patterns(content if isinstance(content, list) else [content], given)
    if not patterns:
        raise InputError(given, "holds no pattern", _REMEDY)
    return patterns


def parse_patterns(content: Sequence[object], where: str) -> list[FailurePattern]:
    """Patterns from plain data.

    Raises:
        InputError: a field is unknown or unusable.
    """
    try:
        return PATTERNS.validate_python(content)
    except ValidationError as error:
        raise InputError(where, describe(error, FailurePattern), _REMEDY) from None


def dump_patterns(patterns: Sequence[FailurePattern]) -> str:
    """The patterns as JSON text that ``read_patterns`` takes."""
    return json.dumps(PATTERNS.dump_python([*patterns], mode="json", exclude_defaults=True), indent=2) + "\n"
