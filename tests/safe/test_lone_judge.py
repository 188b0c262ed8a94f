"""A run of one vehicle that crashes alone is held against records; each dimension can fail by itself."""

import pytest

from roadmend.safe.contact import Part
from roadmend.safe.crash_record import (
    CrashRecord,
    RecordedCollision,
    RecordedImpact,
    RecordedManoeuvre,
    RecordedThing,
    RecordedVehicle,
)
from roadmend.safe.film import Film
from roadmend.safe.judge import judge
from roadmend.safe.likeness import Likeness, run_of
from roadmend.safe.motion import Motion
from roadmend.world.impacts import pose_of
from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_actors import Vehicle
from roadmend.world.scenario_networks import OpenRoadNetwork

from .films import film_of

ROAD = OpenRoadNetwork(lanes=1, backward_lanes=1, length=400.0)


def run(*vehicles, at=(12.0, -5.5), kind="tree", ticks=80):
    """A run on a road to the east with something that stands at a place [m]; the ego is the first vehicle."""
    thing = Obstacle(id="thing", kind=kind, x=at[0], y=at[1])
    actors = [Vehicle(id=name, route=["forward"]) for name, _, _, _ in vehicles[1:]]
    scenario = Scenario(name="run", network=ROAD, ego=Ego(route=["forward"]), actors=actors, obstacles=[thing])
    film = film_of(*vehicles, ego=vehicles[0][0], ticks=ticks)
    for others in film.everyone:
        others["thing"] = pose_of(thing)
    return run_of(scenario, Film(film.ego_name, film.ego, film.objects, film.everyone, frozenset({"thing"})))


EGO = ("ego", (-60.0, -1.6), 0.0, 5.0)
CRASHES = (EGO, ("v1", (10.0, -5.5), -10.0, 15.0))
AT_A_SIDE = (EGO, ("v1", (10.0, -4.4), 0.0, 15.0))  # the tree stands on its right


def record(part=None, *, thing=None, place=None, word=None, heading=0.0, roads=("Straight",), more=0):
    vehicle = RecordedVehicle(1, heading, heading, word and RecordedManoeuvre(word))
    impacts = (RecordedImpact(1, part, thing, place), *[RecordedImpact(1)] * more)
    return CrashRecord("crash", roads, (vehicle,), (), None, len(impacts), impacts)


def failed(what, told):
    return {*judge(what, told).failed}


def test_the_crash_itself_is_reproduced_and_its_later_impacts_are_not_shown():
    found = judge(
        run(*CRASHES), record(Part.FRONT, thing=RecordedThing.UPRIGHT, place=False, word="drift right", more=2)
    )
    assert found.is_reproduced
    assert (found.shown, found.recorded) == (1, 3)


@pytest.mark.parametrize(
    ("told", "dimension"),
    [
        (record(Part.LEFT), Likeness.PARTS),
        (record(Part.REAR), Likeness.PARTS),
        (record(word="drift left"), Likeness.MOTION),
        (record(word="change lane left"), Likeness.MOTION),
        (record(word="reverse"), Likeness.MOTION),
        (record(place=True), Likeness.ROAD),
        (record(roads=("Curve",)), Likeness.ROAD),
        (record(thing=RecordedThing.ALONG_THE_ROAD), Likeness.WHO),
        (record(thing=RecordedThing.VEHICLE), Likeness.WHO),
    ],
)
def test_what_differs_is_named(told, dimension):
    assert dimension in failed(run(*CRASHES), told)
    if "reverse" not in str(told.vehicles[0].manoeuvre):
        assert failed(run(*CRASHES), told) == {dimension}


def test_a_turned_compass_is_another_crash():
    assert failed(run(*CRASHES), record(heading=90.0)) == {Likeness.ORIGIN, Likeness.DESTINATION}
    assert judge(run(*CRASHES), record(heading=315.0)).is_reproduced


def test_a_corner_beside_the_part_counts():
    assert judge(run(*AT_A_SIDE), record(Part.RIGHT)).is_reproduced
    assert judge(run(*AT_A_SIDE), record(Part.FRONT)).is_reproduced
    assert failed(run(*AT_A_SIDE), record(Part.LEFT)) == {Likeness.PARTS}


def test_who_simply_drives_on_reproduces_nothing():
    drives = run(EGO, ("v1", (40.0, -1.6), 0.0, 15.0))
    assert drives.contacts == ()
    assert failed(drives, record()) == {*Likeness}


def test_who_stands_is_not_the_one_that_strikes():
    assert Likeness.WHO in failed(run(EGO, ("v1", (10.0, -5.5), 0.0, 0.0)), record())


def test_a_crash_of_two_vehicles_is_never_taken_for_one_alone_nor_the_other_way_round():
    told = CrashRecord("two", ("Straight",), (), (RecordedCollision(1, 2),), None, 1)
    assert {Likeness.WHO, Likeness.ORDER} <= failed(run(*CRASHES), told)
    both = run(("v1", (0.0, -1.6), 0.0, 15.0), ("v2", (4.0, -1.6), 180.0, 15.0))
    assert {Likeness.WHO, Likeness.ORDER} <= failed(both, record())


def test_an_ego_that_runs_into_the_wreck_makes_it_another_crash():
    late = run(("ego", (6.0, -6.2), -10.0, 16.0), ("v1", (10.0, -5.5), -10.0, 15.0), ticks=80)
    assert Likeness.ORDER in failed(late, record())


def test_an_ego_in_the_place_of_the_vehicle_counts_as_it():
    assert judge(run(("v1", (10.0, -5.5), -10.0, 15.0)), record(Part.FRONT)).is_reproduced


def test_what_a_tree_does_to_a_car_is_no_driving_but_what_comes_before_is():
    what = run(*CRASHES)
    assert what.motions["v1"].is_physical
    assert "thing" not in what.motions
    wild = type(what)(what.scenario, what.film, what.contacts, {"v1": Motion(30.0, 0.0)})
    assert failed(wild, record()) == {Likeness.PHYSICAL}
