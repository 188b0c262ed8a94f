"""A run is held against a record dimension by dimension; each can fail by itself."""

import pytest

from roadmend.safe.contact import Part
from roadmend.safe.crash_record import CrashRecord, RecordedCollision, RecordedManoeuvre, RecordedVehicle
from roadmend.safe.judge import judge
from roadmend.safe.likeness import Likeness, run_of
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_actors import Vehicle
from roadmend.world.scenario_networks import Arm, IntersectionNetwork

from .films import film_of

ARMS = [
    Arm(name=name, bearing=bearing) for name, bearing in (("east", 0), ("north", 90), ("west", 180), ("south", 270))
]
ROUTES = {0.0: ["west_in", "east_out"], 90.0: ["south_in", "north_out"], 180.0: ["east_in", "west_out"]}


def run(*vehicles, arms=ARMS, ticks=80):
    ego, *others = vehicles
    actors = [Vehicle(id=name, route=ROUTES[heading]) for name, _, heading, _ in others]
    scenario = Scenario(
        name="run", network=IntersectionNetwork(arms=arms), ego=Ego(route=ROUTES[ego[2]]), actors=actors
    )
    return run_of(scenario, film_of(*vehicles, ego=ego[0], ticks=ticks))


def record(*collisions, roads=("Intersection",), origins=(0.0, 90.0, None), stem=None, words=(None, None, None)):
    vehicles = tuple(
        RecordedVehicle(number, origin, origin, manoeuvre and RecordedManoeuvre(manoeuvre))
        for number, (origin, manoeuvre) in enumerate(zip(origins, words, strict=True), 1)
    )
    return CrashRecord("crash", roads, vehicles, collisions, stem, len(collisions))


HIT = RecordedCollision(2, 1, Part.FRONT, Part.RIGHT)
SIDE_ON = (("v1", (0.0, 0.0), 0.0, 5.0), ("v2", (0.0, -3.1), 90.0, 9.0))


def failed(what, told):
    return {*judge(what, told).failed}


def test_the_crash_itself_is_reproduced():
    found = judge(run(*SIDE_ON), record(HIT))
    assert found.is_reproduced
    assert (found.shown, found.recorded) == (1, 1)
    later = RecordedCollision(1, 3)
    assert judge(run(*SIDE_ON), record(HIT, later)).recorded == 2


@pytest.mark.parametrize(
    ("told", "dimension"),
    [
        (record(RecordedCollision(1, 2, Part.FRONT, Part.LEFT)), {Likeness.WHO, Likeness.PARTS}),
        (record(RecordedCollision(2, 1, Part.FRONT, Part.LEFT)), {Likeness.PARTS}),
        (record(RecordedCollision(2, 3)), {Likeness.WHO, Likeness.ORDER}),
        (record(RecordedCollision(1, 3), HIT), {Likeness.WHO, Likeness.ORDER}),
        (record(HIT, roads=("Straight", "Curve")), {Likeness.ROAD}),
        (record(HIT, words=("stop", None, None)), {Likeness.MOTION}),
        (record(HIT, words=(None, "reverse", None)), {Likeness.ORIGIN, Likeness.DESTINATION, Likeness.MOTION}),
    ],
)
def test_what_differs_is_named(told, dimension):
    assert failed(run(*SIDE_ON), told) == dimension


def test_a_turned_compass_is_another_crash():
    turned = record(HIT, origins=(90.0, 180.0, None))
    assert failed(run(*SIDE_ON), turned) == {Likeness.ORIGIN, Likeness.DESTINATION}
    assert judge(run(*SIDE_ON), record(HIT, origins=(45.0, 135.0, None))).is_reproduced
    assert judge(run(*SIDE_ON), record(HIT, origins=(None, None, None))).is_reproduced


def test_a_corner_beside_the_part_counts_and_the_next_side_does_not():
    near = RecordedCollision(2, 1, Part.FRONT_LEFT, Part.REAR_RIGHT)
    assert judge(run(*SIDE_ON), record(near)).is_reproduced
    assert failed(run(*SIDE_ON), record(RecordedCollision(2, 1, Part.LEFT, None))) == {Likeness.PARTS}


def test_front_to_front_neither_is_the_one():
    head_on = run(("v1", (0.0, -1.6), 0.0, 1.0), ("v2", (4.5, -1.6), 180.0, 12.0))
    told = record(RecordedCollision(1, 2, Part.FRONT, Part.FRONT), origins=(0.0, 180.0, None))
    assert judge(head_on, told).is_reproduced


def test_one_more_contact_than_the_record_has_spoils_the_order():
    three = run(*SIDE_ON, ("v3", (0.0, -7.6), 90.0, 14.0), ticks=120)
    assert [*map(sorted, (contact.names for contact in three.contacts))] == [["v1", "v2"], ["v2", "v3"]]
    assert Likeness.ORDER in failed(three, record(HIT))
    both = record(HIT, RecordedCollision(3, 2, Part.FRONT, Part.REAR))
    found = judge(three, both)
    assert found.is_reproduced
    assert (found.shown, found.recorded) == (2, 2)


def test_the_stem_and_the_number_of_arms_are_looked_at():
    tee = run(*SIDE_ON, arms=ARMS[:2] + ARMS[3:])
    assert failed(tee, record(HIT, roads=("T-intersection",), stem=180.0)) == {Likeness.ROAD}
    assert failed(run(*SIDE_ON), record(HIT, roads=("T-intersection",))) == {Likeness.ROAD}


def test_who_moves_as_no_vehicle_can_reproduces_nothing():
    what = run(*SIDE_ON)
    jumps = {"v2": type(what.motions["v2"])(30.0, 0.0), "v1": what.motions["v1"]}
    found = judge(type(what)(what.scenario, what.film, what.contacts, jumps), record(HIT))
    assert {*found.failed} == {Likeness.PHYSICAL}
    assert found.is_reproduced_but_for(Likeness.PHYSICAL)


def test_without_a_contact_or_a_collision_nothing_is_reproduced():
    apart = run(("v1", (0.0, 0.0), 0.0, 5.0), ("v2", (0.0, -30.0), 90.0, 9.0))
    assert failed(apart, record(HIT)) == {*Likeness}
    assert failed(run(*SIDE_ON), record()) == {*Likeness}
