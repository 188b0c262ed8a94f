"""Where a vehicle was going to, by its route or by a line of its own."""

import pytest

from roadmend.safe.crash_record import CrashRecord, RecordedManoeuvre, RecordedVehicle
from roadmend.safe.likeness import run_of
from roadmend.safe.own_lines import backwards_line, u_turn_line
from roadmend.safe.way_checks import check_destination
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_actors import Follow, Trigger, Vehicle
from roadmend.world.scenario_networks import OpenRoadNetwork

from .films import film_of

LANE = [(1.6, -200.0), (1.6, 200.0)]
NOW = Trigger(time=0.0)


def differs(heading, number=1, *, bend=0.0, bearing=90.0, manoeuvres=(), word=None, last=None, seen=None):
    """What a record with a heading [deg] says of where v1, the ego, or v2 goes on an open road."""
    actor = Vehicle(id="v2", route=["forward"], manoeuvres=list(manoeuvres))
    network = OpenRoadNetwork(bearing=bearing, bend=bend)
    scenario = Scenario(name="run", network=network, ego=Ego(route=["forward"]), actors=[actor])
    film = film_of(
        ("v1", (0.0, 0.0), bearing, 5.0), ("v2", (0.0, 20.0), bearing if seen is None else seen, 5.0), ticks=3
    )
    vehicle = RecordedVehicle(number, None, heading, word and RecordedManoeuvre(word))
    return check_destination(run_of(scenario, film), CrashRecord("crash", (), (vehicle,), ()), number, last)


@pytest.mark.parametrize(("heading", "fits"), [(-90.0, True), (-45.0, True), (0.0, True), (45.0, False)])
def test_in_a_bend_the_end_and_the_middle_count_and_the_start_does_not(heading, fits):
    assert (differs(heading, bend=-75.0, bearing=0.0) == "") is fits


def test_who_turns_round_goes_back():
    turns = [Follow(when=NOW, points=u_turn_line(LANE, 150.0), speed=5.0)]
    assert differs(270.0, 2, manoeuvres=turns) == ""
    assert "v2 was going to head 270 deg, not 90" in differs(90.0, 2, manoeuvres=turns)
    assert differs(90.0, 2) == ""


def test_who_reverses_goes_where_its_rear_points():
    backs = [Follow(when=NOW, points=backwards_line(LANE, 150.0), speed=3.0, backwards=True)]
    assert differs(270.0, 2, manoeuvres=backs, word="reverse") == ""
    assert differs(90.0, 2, manoeuvres=backs, word="reverse")


def test_who_left_its_road_was_going_where_that_leads():
    leaves = [Follow(when=NOW, points=[(1.6, 0.0), (1.6, 10.0), (40.0, -20.0)], speed=15.0)]
    assert differs(90.0, 2, manoeuvres=leaves, last=2, seen=-40.0) == ""
    assert differs(-40.0, 2, manoeuvres=leaves, last=2, seen=-40.0) == ""  # or by the heading with which it struck
