"""Scenarios on disk: JSON, YAML or the text form, told apart by the ending of the name."""

import json
from pathlib import Path
from typing import Any

import yaml

from roadmend.core.bounded_file import read_text
from roadmend.core.bounds import CRASH
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.core.whole_file import write_text
from roadmend.core.yaml_file import compose_yaml, parse_yaml
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.dsl_data import LONGEST_FIELD, dump_data, parse_data
from roadmend.safe.dsl_text import dump_text, parse_text

_YAML_ENDINGS = {".yaml", ".yml"}


def load_crash_scenario(path: Path) -> CrashScenario:
    """Read a scenario.

    Raises:
        InputError: the file cannot be read or a field of it is unusable; names line and field.
    """
    text = read_text(path, CRASH)
    return parse_crash_scenario(text, path.suffix.lower(), str(path))


def parse_crash_scenario(text: str, ending: str, where: str) -> CrashScenario:
    """Read a scenario from a text.

    Args:
        text: the content.
        ending: ".json", ".yaml", ".yml"; everything else is the text form.
        where: what to call the source in an error.

    Raises:
        InputError: names line and field at fault.
    """
    if ending == ".json":
        return _parse_json(text, where)
    if ending in _YAML_ENDINGS:
        return parse_data(*_read_yaml(text, where))
    return parse_text(text, where)


def dump_crash_scenario(scenario: CrashScenario, ending: str) -> str:
    """The scenario as text, in the form that an ending stands for."""
    if ending == ".json":
        return json.dumps(dump_data(scenario), indent=1) + "\n"
    if ending in _YAML_ENDINGS:
        return yaml.safe_dump(dump_data(scenario), sort_keys=False, allow_unicode=True, width=120)
    return dump_text(scenario)


def save_crash_scenario(scenario: CrashScenario, path: Path) -> None:
    """Write a scenario, complete or not at all.

    Raises:
        InputError: the place cannot be written.
    """
    write_text(path, dump_crash_scenario(scenario, path.suffix.lower()))


def _parse_json(text: str, where: str) -> CrashScenario:
    content = parse_json(text, where, CRASH)
    try:
        _, _, lines = _read_yaml(text, where)  # JSON is YAML, and YAML says where things stand
    except InputError:
        lines = {}
    return parse_data(content, where, lines)


def _read_yaml(text: str, where: str) -> tuple[Any, str, dict[str, int]]:
    content = parse_yaml(text, where, CRASH)
    lines: dict[str, int] = {}
    node = compose_yaml(text, where, CRASH)
    if node is not None:
        _note_lines(node, "", lines)
    return content, where, lines


def _note_lines(node: yaml.Node, path: str, lines: dict[str, int]) -> None:
    if len(path) > LONGEST_FIELD:
        return  # no field of the language: below a long name each of many more would be as long
    lines.setdefault(path, node.start_mark.line + 1)
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            name = f"{path}.{key.value}" if path else str(key.value)
            lines[name] = key.start_mark.line + 1
            _note_lines(value, name, lines)
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            _note_lines(value, f"{path}[{index}]", lines)
