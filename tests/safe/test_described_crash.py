"""A reading as a record to aim at, and the roles that a policy can play."""

import pytest

from roadmend.safe.contact import Part
from roadmend.safe.crash_record import RecordedImpact, RecordedThing
from roadmend.safe.described_crash import record_of, why_not_played
from roadmend.safe.dsl import DescribedCollision, Side

from .crashes import ALL, CROSSING, HEAD_ON, crash, vehicle
from .lone import lone


def test_a_reading_becomes_a_record_with_headings_parts_and_road():
    hit = crash("T-intersection", vehicle("W2E", "Turn Left"), vehicle("N2S"), stem="West",
                collisions=[DescribedCollision(2, 1, Side.FRONT, Side.LEFT)])  # fmt: skip
    record = record_of(hit)
    assert [(each.origin, each.destination) for each in record.vehicles] == [(0.0, 90.0), (270.0, -90.0)]
    (collision,) = record.collisions
    assert (collision.striking_part, collision.struck_part) == (Part.FRONT, Part.LEFT)
    assert (record.roads, record.stem) == (("T-intersection",), 180.0)


def test_what_a_reading_leaves_open_is_not_asked():
    record = record_of(ALL["open"])
    assert (record.roads, record.stem) == ((), None)
    assert all(each.origin is None and each.destination is None for each in record.vehicles)
    assert record_of(ALL["merging"]).vehicles[0].origin is None


@pytest.mark.parametrize(
    ("what", "ego", "words"),
    [
        (
            crash("Straight", vehicle(), vehicle(), vehicle(), collisions=[DescribedCollision(1, 2)]),
            2,
            "not in the first",
        ),
        (crash("Straight", vehicle(manoeuvre="Merge"), vehicle(), lanes=4), 0, "no policy is asked"),
        (HEAD_ON, 1, "no policy is asked"),
        (ALL["alone"], 0, "single vehicle"),
    ],
)
def test_some_crashes_cannot_happen_with_a_policy_in_a_vehicles_place(what, ego, words):
    assert words in why_not_played(what, ego)


def test_who_looks_on_needs_a_vehicle_that_crashes_alone_and_goes_forwards():
    assert why_not_played(ALL["alone"], None) == ""
    backs = crash("Straight", vehicle(manoeuvre="Reverse"))
    assert "does not go forwards" in why_not_played(backs, None)


def test_an_impact_becomes_one_of_a_record_with_its_side_and_kind():
    told = record_of(lone(thing="Pole", part="Left", roadside="Right"))
    assert told.is_alone
    assert told.impacts == (RecordedImpact(1, Part.LEFT, RecordedThing.UPRIGHT, on_roadway=False),)
    assert told.vehicles[0].leaves == -1
    assert record_of(lone(thing="Animal")).impacts[0].on_roadway
    assert record_of(ALL["alone"]).impacts == (RecordedImpact(1),)
    assert record_of(CROSSING).impacts == ()


def test_the_others_can():
    assert why_not_played(ALL["merging"], 1) == ""
    assert why_not_played(CROSSING, 0) == ""
