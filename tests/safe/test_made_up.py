"""Values that a text has no word for."""

import pytest

from roadmend.safe.answer_schema import answer_schema
from roadmend.safe.made_up import _tables, why_made_up


@pytest.mark.parametrize(
    ("limit", "summary", "is_made_up"),
    [
        (40, "The limit is 40 mph.", False),
        (40, "The limit is 64 km/h.", False),
        (50, "The limit is 80 km/h.", False),
        (45, "The limit is 40 mph.", True),
        (45, "In 2045 the limit was 64 km/h.", True),
        (45, "The limit is forty-five.", False),  # not looked into
        (45, "No limit is said.", True),
        (None, "No limit is said.", False),
        (45, "9" * 5000, True),
    ],
)
def test_limits(limit, summary, is_made_up):
    assert (why_made_up("vehicles[0].speed_limit_mph", limit, summary) is not None) is is_made_up


@pytest.mark.parametrize(
    ("field", "value", "summary", "is_made_up"),
    [
        ("env.weather", "Rainy", "It was pouring.", False),
        ("env.weather", "Rainy", "The train was late.", True),  # the beginning of a word counts
        ("env.weather", "Snowy", "It rained.", True),
        ("env.weather", None, "It rained.", False),
        ("vehicles[0].action", "Turn Left", "It went north.", True),
        ("vehicles[0].action", "Turn Left", "He took a left.", False),
        ("vehicles[0].action", "Move Forward", "", False),
        ("vehicles[0].action", ((0.0, 0.0), (9.0, 1.0)), "", False),
        ("collisions[0].struck_side", "Left", "Driver's side.", False),
        ("collisions[0].striking_side", "Rear", "The front of V1.", True),
        ("collisions[0].striking_side", "Front", "", False),
        ("env.time", "Daytime", "", False),
    ],
)
def test_words(field, value, summary, is_made_up):
    assert (why_made_up(field, value, summary) is not None) is is_made_up


def test_the_tables_name_values_of_the_language():
    properties = answer_schema()["properties"]
    vehicle, contact = (properties[name]["items"]["properties"] for name in ("vehicles", "collisions"))
    words = {
        "sides": contact["struck_side"]["enum"],
        "actions": vehicle["action"]["enum"],
        "weather": properties["env"]["properties"]["weather"]["enum"],
    }
    assert _tables().keys() == words.keys()
    for name, table in _tables().items():
        assert {*table} <= {*words[name]}
