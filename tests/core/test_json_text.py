"""JSON from outside: what is slow to look at must not be."""

import json

import pytest

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json


def test_a_name_that_is_there_twice_is_named_the_first_of_several():
    with pytest.raises(InputError, match="field b is there twice"):
        parse_json('{"a": 1, "b": 2, "c": 3, "c": 4, "b": 5}', "file")


@pytest.mark.timeout(20)
def test_it_is_found_among_many_names():
    names = [*range(90_000), 89_999]  # looked at one beside the other they would outlast the tests
    text = "{" + ",".join(f"{json.dumps(str(name))}:1" for name in names) + "}"
    with pytest.raises(InputError, match="field 89999 is there twice"):
        parse_json(text, "file")
