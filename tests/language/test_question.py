"""Schemas for strict modes, and answers held against the type that they come from."""

from dataclasses import dataclass

import pytest
from pydantic import ConfigDict, TypeAdapter

from roadmend.language.chat import AnswerError
from roadmend.language.question import answer_schema, parse_answer


@dataclass(frozen=True)
class Part:
    __pydantic_config__ = ConfigDict(extra="forbid")

    title: str | None = None
    size: float = 1.0


@dataclass(frozen=True)
class Whole:
    __pydantic_config__ = ConfigDict(extra="forbid")

    parts: tuple[Part, ...]


WHOLE = TypeAdapter(Whole)


def test_every_field_is_required_and_none_besides():
    schema = answer_schema(WHOLE)
    part = schema["$defs"]["Part"]
    assert (schema["required"], schema["additionalProperties"]) == (["parts"], False)
    assert (part["required"], part["additionalProperties"]) == (["title", "size"], False)
    assert part["properties"] == {
        "title": {"anyOf": [{"type": "string"}, {"type": "null"}]},
        "size": {"type": "number"},
    }


def test_an_answer_is_read_by_its_type():
    assert parse_answer(WHOLE, '{"parts": [{"title": null, "size": 2}]}') == Whole((Part(None, 2.0),))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("{", "the answer: Invalid JSON"),
        ("[]", "the answer: Input should be"),
        ("{}", "parts: Field required"),
        ('{"parts": [{"size": "2"}]}', "parts.0.size: Input should be a valid number"),
        ('{"parts": [{"colour": 2}]}', "parts.0.colour: Unexpected keyword argument"),
    ],
)
def test_what_is_wrong_is_named(text, complaint):
    with pytest.raises(AnswerError, match=complaint):
        parse_answer(WHOLE, text)
