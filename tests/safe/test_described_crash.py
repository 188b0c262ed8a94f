"""A contact is the described crash only if who, from where, how and who into whom are as the report says."""

import random

import pytest

from roadmend.safe.described_crash import judge, why_not_played
from roadmend.safe.dsl import DescribedCollision, Side
from roadmend.safe.layout import lay_out
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.trial import Contact
from roadmend.world.space import sample

from .crashes import ALL, CROSSING, crash, vehicle

FRONT, REAR, LEFT = (frozenset({side}) for side in (Side.FRONT, Side.REAR, Side.LEFT))


def verdict(what, ego, contact):
    drawn = sample(open_questions(what), random.Random(5))
    return judge(what, lay_out(answer(what, drawn), drawn), ego, contact)


def test_a_contact_from_the_described_sides_and_angle_is_the_crash():
    assert verdict(CROSSING, 0, Contact("v2", LEFT, FRONT, 90.0, 8.0, 2.0)).is_described


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (Contact("v2", FRONT, LEFT, 90.0, 8.0, 2.0), "other way round"),
        (Contact("v2", LEFT, FRONT, 0.0, 8.0, 2.0), "which the manoeuvres do not explain"),
        (Contact("v2", LEFT, FRONT, 90.0, 0.0, 40.0), "had not entered the junction"),
        (Contact("v3", LEFT, FRONT, 90.0, 8.0, 2.0), "no collision with v3"),
    ],
)
def test_every_other_contact_is_not(contact, words):
    what = crash("Intersection", vehicle("W2E"), vehicle("S2N"), vehicle("S2N"), collisions=[DescribedCollision(2, 1)])
    found = verdict(what, 0, contact)
    assert not found.is_described
    assert words in found.reason


def test_who_had_stopped_must_stand_and_head_on_neither_is_the_one():
    stopped = crash("Straight", vehicle(), vehicle(manoeuvre="Stop"), collisions=[DescribedCollision(1, 2)])
    assert "had stopped" in verdict(stopped, 1, Contact("v1", REAR, FRONT, 0.0, 9.0, 0.0)).reason
    assert verdict(stopped, 1, Contact("v1", REAR, FRONT, 0.0, 0.2, 0.0)).is_described
    head_on = crash("Straight", vehicle("W2E"), vehicle("E2W"), collisions=[DescribedCollision(2, 1)])
    assert verdict(head_on, 0, Contact("v2", FRONT, FRONT, 178.0, 9.0, 0.0)).is_described


def test_some_crashes_cannot_happen_with_a_policy_in_a_vehicles_place():
    three = crash("Straight", vehicle(), vehicle(), vehicle(), collisions=[DescribedCollision(1, 2)])
    assert "in no collision" in why_not_played(three, 2)
    merges = crash("Straight", vehicle(manoeuvre="Merge"), vehicle(), lanes=4)
    assert "no policy is asked" in why_not_played(merges, 0)
    assert why_not_played(ALL["merging"], 1) == ""
