"""The text of a report cut into phrases by the fields that were read from it."""

import pytest

from roadmend.reports.crash_phrases import Phrase, colour_of, family_of, phrases_of

TEXT = "V1 went north on a road."


def test_the_phrases_are_the_whole_text():
    phrases = phrases_of(TEXT, {"vehicles[0].initial_position": {"span": (8, 13)}, "road_type": {"span": (19, 23)}})
    assert "".join(phrase.text for phrase in phrases) == TEXT
    assert [phrase for phrase in phrases if phrase.fields] == [
        Phrase("north", ("vehicles[0].initial_position",)),
        Phrase("road", ("road_type",)),
    ]


def test_where_spans_overlap_the_narrowest_gives_the_colour():
    phrases = phrases_of(TEXT, {"road_type": {"span": (0, 23)}, "vehicles[0].initial_position": {"span": (8, 13)}})
    (inner,) = [phrase for phrase in phrases if phrase.text == "north"]
    assert inner.fields == ("vehicles[0].initial_position", "road_type")
    assert inner.colour == colour_of("vehicles[0].initial_position") != colour_of("road_type")


@pytest.mark.parametrize("span", [None, (5, 5), (-1, 4), (3, 99), (9, 2)])
def test_a_span_that_is_none_is_left_out(span):
    assert phrases_of(TEXT, {"road_type": {"span": span}}) == (Phrase(TEXT),)


def test_without_a_text_there_are_no_phrases():
    assert phrases_of("", {"road_type": {"span": (0, 4)}}) == ()


@pytest.mark.parametrize(
    ("field", "family"),
    [
        ("road_type", "road"),
        ("vehicles[1].model", "vehicle 2"),
        ("env.time", "environment"),
        ("collisions[0].striking", "contact"),
    ],
)
def test_families(field, family):
    assert family_of(field) == family


def test_each_vehicle_has_its_colour():
    assert len({colour_of(f"vehicles[{index}].model") for index in range(4)}) == 4
    assert colour_of("vehicles[0].model") == colour_of("vehicles[0].action")


def test_what_was_struck_is_a_contact():
    assert family_of("impacts[0].object") == family_of("collisions[0].striking") == "contact"
