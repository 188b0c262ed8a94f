"""Who sits in which vehicle, and what is only met, owned by nobody, or a load."""

import pytest

from roadmend.safe.reading.seats import seats_of

from .apart import named, taken_apart


def seated(text):
    """Words of each person with those of the vehicle that she or he sits in, and the names of those who sit in one."""
    structure = taken_apart(text)
    row = [group.mention for group in structure.groups if group.mention is not None]
    seats = seats_of([structure], [row])

    def words(mention):
        return " ".join(item.low for item in structure.items[mention.first : mention.last + 1])

    return {words(each): words(seats.partner[id(each)]) for each in row if id(each) in seats.partner}, [
        *seats.named.values()
    ]


@pytest.mark.parametrize(
    ("text", "person", "vehicle"),
    [
        ("She was driving a Kia Soul north.", "she", "a kia soul"),
        ("I was in the Honda Civic.", "i", "the honda civic"),
        ("A man in a Ford pickup turned left.", "a man", "a ford pickup"),
    ],
)
def test_people_are_put_into_vehicles(text, person, vehicle):
    assert seated(text)[0][person] == vehicle


def test_a_name_is_put_into_a_vehicle():
    assert seated("Ortiz's Ford pickup struck V2.")[1] == ["ortiz"]


def test_who_only_meets_a_vehicle_does_not_sit_in_it():
    assert seated("She collided with a Ford pickup.") == ({}, [])


def test_nobody_sits_in_a_vehicle_that_is_only_named():
    _, row = named("A Ford pickup turned left.")
    assert len(row) == 1
    assert seated("A Ford pickup turned left.") == ({}, [])
