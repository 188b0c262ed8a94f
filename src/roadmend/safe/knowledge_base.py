"""The knowledge base of analysis templates, by road type and driving direction."""

import functools
import importlib.resources
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, Field, InstanceOf

from roadmend.core.parameters import Parameters
from roadmend.core.settings import check_settings
from roadmend.core.yaml_file import parse_yaml
from roadmend.language.chat import Image
from roadmend.safe.compass import NORTH_SOUTH
from roadmend.safe.dsl import CrashScenario, Position, RoadType
from roadmend.safe.dsl_data import parse_data

_FOLDER = importlib.resources.files(__package__).joinpath("knowledge")


class WorkedExample(Parameters):
    """A made-up case with its analysis, step by step."""

    model_config = ConfigDict(strict=False)

    directions: tuple[Position, ...] = Field(description="the vehicles' initial positions, by which it is found")
    summary: str = Field(description="the report's text")
    analysis: str = Field(description="how a careful reader gets from the text to the answer")
    answer: Annotated[InstanceOf[CrashScenario], BeforeValidator(lambda content: parse_data(content, "answer"))]
    picture: str = Field(pattern=r"^[a-z0-9-]+\.png$", description="file of its sketch, which example_sketch draws")

    @cached_property
    def sketch(self) -> Image:
        """Its sketch."""
        return Image(_FOLDER.joinpath(self.picture).read_bytes(), "image/png")


class Template(Parameters):
    """How to analyse a crash on one type of road; a file of the folder knowledge."""

    model_config = ConfigDict(strict=False)

    road_type: RoadType
    guidance: str
    examples: tuple[WorkedExample, ...] = Field(min_length=1)


@functools.cache
def templates() -> Mapping[RoadType, Template]:
    """All that there are."""
    templates = [
        check_settings(parse_yaml(file.read_text(encoding="utf-8"), file.name), Template, file.name, "mend the file")
        for file in _FOLDER.iterdir()
        if file.name.endswith(".yaml")
    ]
    return {template.road_type: template for template in templates}


def retrieve(road_type: RoadType, directions: Sequence[Position | None]) -> tuple[Template, WorkedExample]:
    """The template of a road type, and of its examples the one whose vehicles travel most alike.

    Args:
        road_type: the index' first part.
        directions: of the vehicles, as far as known: its second part.
    """
    template = templates()[road_type]
    return template, max(template.examples, key=lambda example: _likeness(example.directions, directions))


def _likeness(one: Sequence[Position], other: Sequence[Position | None]) -> tuple[int, int]:
    """How the vehicles stand to each other counts first, the compass second."""
    known = [direction for direction in other if direction is not None]
    shared = (Counter(one) & Counter(known)).total()
    return int(_pattern(one) == _pattern(known)), shared


def _pattern(directions: Sequence[Position]) -> str:
    axes = {direction in NORTH_SOUTH for direction in directions}
    if len(set(directions)) <= 1:
        return "same"
    return "crossing" if len(axes) > 1 else "opposite"
