"""The schema that a model answers by holds all that the language holds."""

import json
from dataclasses import replace
from enum import StrEnum

import pytest
from hypothesis import given, settings

from roadmend.safe.answer_schema import _schema, answer_schema
from roadmend.safe.dsl import Manoeuvre, Position, RoadType, Side
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.knowledge_base import templates
from roadmend.safe.prompts import EXTRACTION_SCHEMA, VALIDATION_SCHEMA, extraction_request
from roadmend.safe.report import CrashReport

from .scenarios import scenarios

KINDS = {"object": dict, "array": list, "string": str, "integer": int, "number": int | float, "boolean": bool}


def faults(content, schema, place="answer"):
    """What of a JSON Schema's demands content does not meet, as far as strict modes know them."""
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if content is None:
        return [] if "null" in kinds else [f"{place} is null"]
    if not any(isinstance(content, KINDS[kind]) for kind in kinds if kind != "null"):
        return [f"{place} is no {kinds}"]
    found = [] if content in schema.get("enum", [content]) else [f"{place} is none of the words"]
    if "properties" in schema:
        found += [f"{place}.{name} is unknown" for name in content.keys() - schema["properties"].keys()]
        for name in content.keys() & schema["properties"].keys():
            found += faults(content[name], schema["properties"][name], f"{place}.{name}")
    if "items" in schema:
        for index, each in enumerate(content):
            found += faults(each, schema["items"], f"{place}[{index}]")
    return found


def complete(schema):
    """An answer with every field of a schema in it, open where it may be."""
    if "properties" in schema:
        return {name: complete(each) for name, each in schema["properties"].items()}
    if schema["type"] == "array":
        return []
    return None


def without_own(scenario):
    """A scenario without a user's own fields and points in place of an action, for which no model is asked."""
    vehicles = tuple(
        replace(each, extras={}, action=None if isinstance(each.action, tuple) else each.action)
        for each in scenario.vehicles
    )
    return replace(scenario, vehicles=vehicles, environment=replace(scenario.environment, extras={}), extras={})


@given(scenario=scenarios())
@settings(max_examples=150, deadline=None)
def test_every_scenario_fits(scenario):
    assert faults(dump_data(without_own(scenario)), answer_schema()) == []


def test_every_field_of_it_is_read():
    answer = complete(answer_schema())
    answer["vehicles"] = [complete(answer_schema()["properties"]["vehicles"]["items"])] * 2
    contact = complete(answer_schema()["properties"]["collisions"]["items"]) | {"striking": 2, "struck": 1}
    answer["collisions"] = [contact]
    scenario = parse_data(answer, "answer")
    assert (len(scenario.vehicles), len(scenario.collisions)) == (2, 1)


def test_it_is_strict():
    def objects(node):
        if isinstance(node, dict):
            if node.get("type") == "object":
                yield node
            for each in node.values():
                yield from objects(each)

    for schema in (EXTRACTION_SCHEMA, VALIDATION_SCHEMA):
        for each in objects(schema):
            assert each["additionalProperties"] is False
            assert each["required"] == [*each["properties"]]


def test_it_holds_the_words_of_the_language():
    properties = answer_schema()["properties"]
    vehicle, contact = (properties[name]["items"]["properties"] for name in ("vehicles", "collisions"))
    assert vehicle["manoeuvre"]["enum"] == [*(word.value for word in Manoeuvre), None]
    assert vehicle["initial_position"]["enum"] == [*(word.value for word in Position), None]
    assert contact["struck_side"]["enum"] == [*(word.value for word in Side), None]
    assert contact["striking"] == {"type": "integer"}


def test_the_prompt_explains_every_word():
    request = extraction_request(CrashReport("case", "V1 hit V2."), None, ())
    task = request.messages[1].parts[0]
    for word in (*Manoeuvre, *Position, *Side):
        assert word.value in task
    for name in ("collisions", "striking_side", "manoeuvre", "num_lanes"):
        assert f"{name}:" in task


@pytest.mark.parametrize("road_type", RoadType)
def test_the_examples_are_answers_as_they_are_asked_for(road_type):
    for example in templates()[road_type].examples:
        request = extraction_request(CrashReport("case", "V1 hit V2."), (templates()[road_type], example), ())
        answer = json.loads(request.messages[3].parts[0].split("The answer:\n")[1])
        assert faults(answer, EXTRACTION_SCHEMA) == []
        assert [*answer["scenario"]] == [*answer_schema()["properties"]]
        assert parse_data(answer["scenario"], "answer") == example.answer


def test_a_type_that_it_does_not_know_is_told_at_once():
    with pytest.raises(TypeError, match="has no schema"):
        _schema(bytes)
    with pytest.raises(TypeError, match="one kind"):
        _schema(int | str)
    assert _schema(StrEnum("Word", ["A"]))["enum"] == ["a"]
