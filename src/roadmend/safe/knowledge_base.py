"""The knowledge base of analysis templates, by road type and driving direction."""

import functools
import importlib.resources
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import yaml

from roadmend.safe.dsl import CrashScenario, Position, RoadType
from roadmend.safe.dsl_data import parse_data


@dataclass(frozen=True, slots=True)
class WorkedExample:
    """A made-up case with its analysis, step by step.

    Attributes:
        directions: the vehicles' initial positions, by which it is found.
        summary: the report's text.
        analysis: how a careful reader gets from the text to the answer.
        answer: the scenario.
    """

    directions: tuple[Position, ...]
    summary: str
    analysis: str
    answer: CrashScenario


@dataclass(frozen=True, slots=True)
class Template:
    """How to analyse a crash on one type of road."""

    road_type: RoadType
    guidance: str
    examples: tuple[WorkedExample, ...]


@functools.cache
def _templates() -> dict[RoadType, Template]:
    folder = importlib.resources.files(__package__).joinpath("knowledge")
    templates = [
        _read(file.name, file.read_text(encoding="utf-8")) for file in folder.iterdir() if file.name.endswith(".yaml")
    ]
    return {template.road_type: template for template in templates}


def _read(name: str, text: str) -> Template:
    content = yaml.safe_load(text)
    examples = tuple(
        WorkedExample(
            tuple(Position(direction) for direction in example["directions"]),
            example["summary"],
            example["analysis"],
            parse_data(example["answer"], name),
        )
        for example in content["examples"]
    )
    return Template(RoadType(content["road_type"]), content["guidance"], examples)


def retrieve(road_type: RoadType, directions: Sequence[Position | None]) -> tuple[Template, WorkedExample]:
    """The template of a road type, and of its examples the one whose vehicles travel most alike.

    Args:
        road_type: the index' first part.
        directions: of the vehicles, as far as known: its second part.
    """
    template = _templates()[road_type]
    return template, max(template.examples, key=lambda example: _likeness(example.directions, directions))


def _likeness(one: Sequence[Position], other: Sequence[Position | None]) -> tuple[int, int]:
    """How the vehicles stand to each other counts first, the compass second."""
    known = [direction for direction in other if direction is not None]
    shared = (Counter(one) & Counter(known)).total()
    return int(_pattern(one) == _pattern(known)), shared


def _pattern(directions: Sequence[Position]) -> str:
    axes = {"ns" if direction in {Position.N2S, Position.S2N} else "ew" for direction in directions}
    if len(set(directions)) <= 1:
        return "same"
    return "crossing" if len(axes) > 1 else "opposite"
