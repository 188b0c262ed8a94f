"""Noun groups: a vehicle with its part, a part of one, a place that is somebody's."""

import pytest

from roadmend.safe.reading.groups import groups_of

from .apart import named, words


def groups(text):
    sentence, row = named(text)
    return sentence.items, groups_of(sentence.items, row)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("V1's left side was struck.", ["v 1 's left side"]),
        ("The front of the van struck V2.", ["the front of the van", "v 2"]),
        ("V1 struck the right side of V2.", ["v 1", "the right side of v 2"]),
    ],
)
def test_a_vehicle_and_its_part_are_one_group(text, said):
    items, found = groups(text)
    assert [words(items, group) for group in found] == said


def test_the_part_is_kept_with_its_vehicle():
    _, (group,) = groups("V1's left side was damaged.")
    assert group.mention.number == 1
    assert group.part is not None
    assert not group.is_place


def test_somebodys_lane_is_a_place_and_not_somebody():
    _, (_, group) = groups("V1 was in V2's lane.")
    assert (group.mention.number, group.part, group.is_place) == (2, None, True)


def test_a_part_of_nobody_has_no_vehicle():
    _, found = groups("The left side was damaged.")
    assert [(group.mention, group.part is not None) for group in found] == [(None, True)]
