"""Which vehicle of one reading is which of another, and what contacts are then the same."""

import pytest

from roadmend.safe.dsl import DescribedCollision, Side
from roadmend.safe.reading_alignment import aligned_fields, flat

from .crashes import crash, vehicle
from .lone import lone

PICKUP, SEDAN, SUV = (
    vehicle("W2E", model="Pickup", limit=40),
    vehicle("N2S", "Turn Left", limit=25),
    vehicle("E2W", model="SUV"),
)
HIT = DescribedCollision(1, 2, Side.FRONT, Side.LEFT)
UNNUMBERED, NUMBERED = "A pickup hit a sedan.", "V1, a pickup, hit V2, a sedan."


def values(answered, read, summary=UNNUMBERED):
    return {name: each.value for name, each in aligned_fields(answered, read, summary).items()}


def test_the_same_is_the_same():
    scene = crash("Intersection", PICKUP, SEDAN, collisions=[HIT])
    assert values(scene, scene) == flat(scene)
    assert all(name == each.field for name, each in aligned_fields(scene, scene, NUMBERED).items())


def test_vehicles_without_numbers_may_stand_in_another_order():
    answered = crash("Intersection", PICKUP, SEDAN, collisions=[HIT])
    read = crash("Intersection", SEDAN, PICKUP, collisions=[DescribedCollision(2, 1, Side.FRONT, Side.LEFT)])
    assert values(answered, read) == flat(answered)
    assert aligned_fields(answered, read, UNNUMBERED)["vehicles[0].model"].field == "vehicles[1].model"
    assert values(answered, read, NUMBERED)["vehicles[0].model"] == "Sedan"


def test_what_a_vehicle_alone_struck_is_compared_where_both_name_it():
    tree, pole = lone(part="Left", roadside="Right"), lone(thing="Pole", part="Left")
    found = values(tree, pole, NUMBERED)
    assert {name: value for name, value in found.items() if name.startswith("impacts")} == {
        "impacts[0].object": "Pole",
        "impacts[0].striking_side": "Left",
    }
    assert flat(tree)["impacts[0].roadside"] == "Right"
    assert not any(name.startswith("impacts") for name in values(lone(thing=None), pole, NUMBERED))


def test_one_field_does_not_change_the_order():
    answered = crash("Straight", vehicle(model="Pickup"), vehicle())
    read = crash("Straight", vehicle(), vehicle())
    assert values(answered, read)["vehicles[0].model"] == "Sedan"


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_a_vehicle_less(missing):
    every = [PICKUP, SEDAN, SUV]
    answered = crash("Intersection", *every)
    read = crash("Intersection", *every[:missing], *every[missing + 1 :])
    for one, other, left in ((answered, read, 2), (read, answered, 2)):
        found = values(one, other)
        mine = flat(one)
        assert all(value == mine[name] for name, value in found.items() if name.startswith("vehicles["))
        assert len({name.split("]")[0] for name in found if name.startswith("vehicles[")}) == left


class TestContacts:
    """The answer says that the front of 1 met the left of 2."""

    def contact(self, read):
        answered = crash("Intersection", PICKUP, SEDAN, collisions=[HIT])
        found = values(answered, crash("Intersection", PICKUP, SEDAN, collisions=[read]), NUMBERED)
        return [found[f"collisions[0].{name}"] for name in ("striking", "struck", "striking_side", "struck_side")]

    def test_other_sides(self):
        assert self.contact(DescribedCollision(1, 2, Side.FRONT, Side.REAR)) == [1, 2, "Front", "Rear"]

    def test_the_other_way_round(self):
        assert self.contact(DescribedCollision(2, 1, Side.LEFT, Side.FRONT)) == [2, 1, "Front", "Left"]

    def test_front_to_front_neither_runs_into_the_other(self):
        assert self.contact(DescribedCollision(2, 1, Side.FRONT, Side.FRONT)) == [1, 2, "Front", "Front"]

    def test_nor_side_to_side(self):
        assert self.contact(DescribedCollision(2, 1, Side.LEFT, Side.RIGHT)) == [1, 2, "Right", "Left"]

    def test_only_those_that_both_have(self):
        answered = crash("Intersection", PICKUP, SEDAN)
        read = crash("Intersection", PICKUP, SEDAN, collisions=[HIT])
        found = values(answered, read)
        assert found["collisions"] == 1
        assert "collisions[0].striking" not in found
