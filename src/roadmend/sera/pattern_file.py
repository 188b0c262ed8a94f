"""Failure patterns as the user gives them: a file, or words."""

import json
from collections.abc import Sequence
from pathlib import Path

import yaml
from pydantic import TypeAdapter, ValidationError

from roadmend.core.errors import InputError
from roadmend.sera.pattern import FailurePattern
from roadmend.world.scenario_file import describe

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
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(given, "no such file", _REMEDY) from None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(given, f"cannot be read ({' '.join(str(error).split())})", _REMEDY) from None
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
        raise InputError(where, describe(error), _REMEDY) from None


def dump_patterns(patterns: Sequence[FailurePattern]) -> str:
    """The patterns as JSON text that ``read_patterns`` takes."""
    return json.dumps(PATTERNS.dump_python([*patterns], mode="json", exclude_defaults=True), indent=2) + "\n"
