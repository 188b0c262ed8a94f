"""Scenarios on disk: YAML in, YAML out, errors in one line."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_text
from roadmend.world.scenario import NetworkFile, Scenario, SumoConfiguration

SUFFIXES = frozenset({".yaml", ".yml"})


def load_scenario(path: Path) -> Scenario:
    """Read a scenario; files it names become absolute paths.

    Raises:
        InputError: the file is missing, is no YAML, or a field of it is unusable.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(
            str(path), "no such file", "give the path of a scenario; 'roadmend sample' makes one"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read ({error})", "give a readable UTF-8 text file") from None
    try:
        content = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark is not None else ""
        problem = getattr(error, "problem", None) or "cannot be parsed"
        raise InputError(str(path), f"broken YAML{line}: {problem}", "mend the line") from None
    if not isinstance(content, Mapping):
        raise InputError(str(path), "holds no fields", "see 'roadmend schema' for what a scenario has")
    scenario = parse_scenario(content, str(path))
    return _with_absolute_paths(scenario, path.parent)


def load_scenarios(paths: Iterable[Path]) -> list[Scenario]:
    """Read scenarios from files, and from folders all that lie in them.

    Raises:
        InputError: a file is missing or unusable, a folder holds none, or two scenarios have one name.
    """
    found: dict[str, Path] = {}
    scenarios = []
    for given in paths:
        files = sorted(each for each in given.iterdir() if each.suffix in SUFFIXES) if given.is_dir() else [given]
        if not files:
            raise InputError(str(given), "holds no scenario", "'roadmend sample' makes one")
        for path in files:
            scenario = load_scenario(path)
            if scenario.name in found:
                what = f"has the name {scenario.name!r}, as {found[scenario.name]} has"
                raise InputError(str(path), what, "give each scenario a name of its own")
            found[scenario.name] = path
            scenarios.append(scenario)
    return scenarios


def parse_scenario(content: Mapping[str, Any], where: str) -> Scenario:
    """Check plain data against the scenario model.

    Raises:
        InputError: names the first field at fault.
    """
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise InputError(where, describe(error), "see 'roadmend schema' for what is allowed") from None


def describe(error: ValidationError) -> str:
    """The faults of a validation error as one line: the first one, and how many more there are."""
    faults = error.errors()
    first = faults[0]
    place = _place(first["loc"])
    if first["type"] == "extra_forbidden":
        text = f"field {place} is unknown"
    elif first["type"] == "missing":
        text = f"field {place} is missing"
    else:
        message = first["msg"].removeprefix("Value error, ")
        message = message[:1].lower() + message[1:]
        given = first.get("input")
        shown = f" (got {json.dumps(given)})" if isinstance(given, str | int | float | bool) else ""
        text = f"field {place}: {message}{shown}" if place else message
    more = len(faults) - 1
    return text + (f" (and {more} more)" if more else "")


def _place(location: Sequence[int | str]) -> str:
    place = ""
    for part in location:
        place += f"[{part}]" if isinstance(part, int) else f".{part}" if place else part
    return place


def _with_absolute_paths(scenario: Scenario, base: Path) -> Scenario:
    network = scenario.network
    if isinstance(network, NetworkFile | SumoConfiguration):
        absolute = str((base / network.path).resolve())
        return scenario.model_copy(update={"network": network.model_copy(update={"path": absolute})})
    return scenario


def dump_scenario(scenario: Scenario) -> str:
    """The scenario as YAML text."""
    content = scenario.model_dump(mode="json", exclude_none=True)
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)


def save_scenario(scenario: Scenario, path: Path) -> None:
    """Write a scenario as YAML, complete or not at all.

    Raises:
        InputError: the place cannot be written.
    """
    write_text(path, dump_scenario(scenario))


def scenario_schema() -> dict[str, Any]:
    """JSON schema of a scenario file."""
    schema = Scenario.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
