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


@pytest.mark.timeout(20)
@pytest.mark.parametrize(
    "text",
    [
        "<think>" * 200_000,
        "</think><think>" * 100_000,
        "```\n" + " " * 400_000,
        "```\n" * 100_000,
        "```" + " " * 400_000,
    ],
    ids=["thoughts", "thoughts that end before", "a fence of spaces", "fences", "a fence and spaces"],
)
def test_marks_without_an_end_are_looked_at_once(text):
    json_in(f"{text}x", SCHEMA)  # from each of them to the end it would outlast the tests
