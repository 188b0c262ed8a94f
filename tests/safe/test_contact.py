"""Who touched whom, on which part of both, and in which order."""

import pytest

from roadmend.safe.contact import Part, find_contacts

from .films import film_of


@pytest.mark.parametrize(
    ("place", "heading", "parts"),
    [
        ((4.5, 0.0), 0.0, (Part.FRONT, Part.REAR)),
        ((4.5, 0.0), 180.0, (Part.FRONT, Part.FRONT)),
        ((0.0, 3.1), 270.0, (Part.LEFT, Part.FRONT)),
        ((0.0, -3.1), 90.0, (Part.RIGHT, Part.FRONT)),
        ((-4.5, 0.0), 0.0, (Part.REAR, Part.FRONT)),
        ((4.5, 1.7), 180.0, (Part.FRONT_LEFT, Part.FRONT_LEFT)),
    ],
)
def test_the_parts_are_those_that_touch(place, heading, parts):
    speed = 2.0 if place[0] > 0.0 and heading == 0.0 else 9.0
    (contact,) = find_contacts(film_of(("v1", (0.0, 0.0), 0.0, 5.0), ("v2", place, heading, speed)))
    assert (contact.one.part, contact.other.part) == parts


def test_who_moves_towards_the_place_approaches_and_who_is_struck_from_behind_leaves_it():
    (contact,) = find_contacts(film_of(("v1", (0.0, 0.0), 0.0, 12.0), ("v2", (4.5, 0.0), 0.0, 2.0)))
    assert contact.of("v1").approach == pytest.approx(12.0, abs=0.1)
    assert contact.of("v2").approach == pytest.approx(-2.0, abs=0.1)


def test_contacts_come_in_their_order_and_a_pair_once():
    film = film_of(
        ("v1", (0.0, 0.0), 0.0, 5.0), ("v2", (4.0, 0.0), 180.0, 5.0), ("v3", (8.5, 0.1), 180.0, 9.0), ticks=100
    )
    assert [contact.names for contact in find_contacts(film)] == [frozenset({"v1", "v2"}), frozenset({"v2", "v3"})]
    assert find_contacts(film_of(("v1", (0.0, 0.0), 0.0, 5.0), ("v2", (0.0, 9.0), 0.0, 5.0))) == []


def test_a_part_is_near_itself_and_its_corners():
    assert [part for part in Part if part.is_near(Part.FRONT)] == [Part.FRONT, Part.FRONT_LEFT, Part.FRONT_RIGHT]
