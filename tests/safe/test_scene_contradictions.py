"""What excludes each other in a scene, and what may well be."""

import pytest

from roadmend.safe.dsl import DescribedCollision, DescribedEnvironment, Side, Time, Weather
from roadmend.safe.knowledge_base import templates
from roadmend.safe.scene_contradictions import contradictions

from .crashes import ALL, crash, vehicle


def hit(striking, struck, striking_side="Front", struck_side=None):
    return DescribedCollision(
        striking, struck, Side(striking_side) if striking_side else None, Side(struck_side) if struck_side else None
    )


@pytest.mark.parametrize("name", ALL)
def test_scenes_that_may_be(name):
    found = contradictions(ALL[name])
    assert found == [] or (name == "pile-up" and "no part" in found[0].reason)


def test_the_examples_of_the_knowledge_base_may_be():
    for template in templates().values():
        for example in template.examples:
            assert contradictions(example.answer) == []


# Position and action of the one that strikes with its front and of the one that is struck, and the sides that this can meet.
MEETINGS = [
    (("E2W", "Move Forward"), ("S2N", "Move Forward"), "Right Front Rear"),
    (("W2E", "Move Forward"), ("S2N", "Move Forward"), "Left Front Rear"),
    (("N2S", "Move Forward"), ("S2N", "Turn Left"), "Right Front Left Rear"),  # still straight, or across already
    (("N2S", "Turn Left"), ("S2N", "Move Forward"), "Left Front Right Rear"),
    (("N2S", "Move Forward"), ("W2E", "Turn Left"), "Left Front Right Rear"),
    (("S2N", "Move Forward"), ("S2N", "Move Forward"), "Rear Left Right"),
    (("S2N", "Move Forward"), ("N2S", "Move Forward"), "Front Left Right"),
]


@pytest.mark.parametrize("side", ["Front", "Rear", "Left", "Right"])
@pytest.mark.parametrize(("one", "other", "possible"), MEETINGS)
def test_contacts_at_a_junction(one, other, possible, side):
    scene = crash("Intersection", vehicle(*one), vehicle(*other), collisions=[hit(1, 2, struck_side=side)])
    assert (contradictions(scene) == []) == (side in possible.split())


def test_a_contact_that_cannot_be_names_all_that_says_so():
    scene = crash("Intersection", vehicle("E2W"), vehicle("S2N"), collisions=[hit(1, 2, struck_side="Left")])
    (found,) = contradictions(scene)
    assert {"collisions[0].struck_side", "vehicles[0].initial_position", "vehicles[1].action"} <= {*found.fields}
    assert found.reason == (
        "the front of vehicle 1 cannot meet the Left of vehicle 2, "
        "as they come E2W with Move Forward and S2N with Move Forward"
    )


def test_after_a_first_contact_a_vehicle_may_stand_anyhow():
    vehicles = (vehicle("E2W"), vehicle("S2N"), vehicle("N2S"))
    hits = [hit(1, 2, struck_side="Right"), hit(3, 2, struck_side="Rear")]
    assert contradictions(crash("Intersection", *vehicles, collisions=hits)) == []


@pytest.mark.parametrize(
    ("vehicles", "count"),
    [
        ([vehicle("W2E", "Turn Left"), vehicle("N2S")], 0),
        ([vehicle("W2E", "Turn Right"), vehicle("S2N", "Turn Left")], 0),
        ([vehicle("W2E"), vehicle("N2S")], 1),  # out of the stem straight on
        ([vehicle("E2W"), vehicle("N2S")], 1),  # from where there is no leg
        ([vehicle("W2E", "Turn Left"), vehicle("N2S", "Turn Left")], 1),  # to where there is none
        ([vehicle(None), vehicle("N2S", None)], 0),
    ],
)
def test_the_stem_is_a_leg_and_what_faces_it_is_none(vehicles, count):
    assert len(contradictions(crash("T-intersection", *vehicles, stem="West"))) == count
    assert contradictions(crash("T-intersection", *vehicles)) == []


def test_who_is_alone_may_run_on_where_there_is_no_leg():
    assert contradictions(crash("T-intersection", vehicle("W2E"), stem="West")) == []


def test_crossing_ways_need_a_junction_or_a_turn():
    assert contradictions(crash("Straight", vehicle("W2E"), vehicle("N2S")))
    assert not contradictions(crash("Straight", vehicle("W2E"), vehicle("N2S", "Turn Left")))
    assert not contradictions(crash("Curve", vehicle("W2E"), vehicle("N2S")))


def test_whoever_is_in_the_scene_touched():
    (found,) = contradictions(crash("Straight", vehicle(), vehicle(), vehicle(), collisions=[hit(1, 2)]))
    assert found.fields == ("vehicles", "collisions")
    assert "vehicle 3" in found.reason


def test_manoeuvre_and_action():
    (found,) = contradictions(crash("Intersection", vehicle("W2E", "Turn Left", "Turn Right"), vehicle("S2N")))
    assert found.fields == ("vehicles[0].action", "vehicles[0].manoeuvre")
    assert not contradictions(crash("Straight", vehicle("W2E", "Move Forward", "Stop")))


def test_the_sun_at_night():
    night = DescribedEnvironment(Time.NIGHTTIME, Weather.SUNNY)
    assert contradictions(crash("Straight", vehicle(), environment=night))
