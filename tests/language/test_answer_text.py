"""Where in a text an answer stands; those that endpoints send are in test_misbehaviour."""

import pytest

from roadmend.language.answer_text import json_in

SCHEMA = {"required": ["colour"]}
RED, BLUE = '{"colour": "red"}', '{"colour": "blue"}'


@pytest.mark.parametrize(
    "text",
    [
        f"<think>{BLUE}</think>{RED}",
        f"<Think>{BLUE}</tHINK> {RED}",
        f"<think>{BLUE}</think>{RED}<thinking>{BLUE}</thinking>",
        f"<think>{BLUE}</thinking> still {BLUE}</think>{RED}",  # an end of another name ends nothing
        f"<think>{BLUE}<think>{BLUE}</think>{RED}",
        f"<think>{BLUE}</think>{BLUE}</reasoning>{RED}",  # the begin of the second stands in the prompt
        f"<thought> I say {RED}",  # without an end they are none
        f"```json\n{RED}\n```",
        f"```json\n{RED}   ```",
        f"```  \n\n{RED}\n\n  ```\n```\n{RED}\n```",
        f"````json\n{RED}\n````",
        f"```json\n```\n```\n{RED}\n```",
        f"```json {BLUE[:-1]}\n```\n{RED}\n```\n",
        f"```\n{RED}\nand so on",  # a fence without an end is prose
    ],
)
def test_the_one_that_counts(text):
    assert json_in(text, SCHEMA) == RED


QUOTING = '{"colour": "as in <think>red</think>"}'
ENDING = '{"colour": "</think>"}'
PLACE = "HERE"


@pytest.mark.parametrize("quoting", [QUOTING, ENDING, '{"colour": "<reasoning>"}'])
@pytest.mark.parametrize(
    "around",
    [
        PLACE,
        f"Answer: {PLACE} ok",
        f"```json\n{PLACE}\n```",
        f"<think>{BLUE} or {ENDING}?</think>{PLACE}",
        f"{PLACE}<think>x</think>",
    ],
)
def test_a_mark_that_the_answer_quotes_is_a_part_of_it(around, quoting):
    assert json_in(around.replace(PLACE, quoting), SCHEMA) == quoting


def test_what_is_only_considered_is_no_answer():
    assert json_in(f"<think>{QUOTING}</think>none", SCHEMA) == "none"


@pytest.mark.timeout(20)
@pytest.mark.parametrize(
    "text",
    [
        "<think>" * 200_000,
        "</think><think>" * 100_000,
        "```\n" + " " * 400_000,
        "```\n" * 100_000,
        "```" + " " * 400_000,
        '{"a": 1}' * 300 + "<think>" * 200_000,
    ],
    ids=["thoughts", "thoughts that end before", "a fence of spaces", "fences", "a fence and spaces", "objects before"],
)
def test_marks_without_an_end_are_looked_at_once(text):
    json_in(f"{text}x", SCHEMA)  # from each of them to the end it would outlast the tests
