"""Every kind of crash becomes a scenario that loads, with what was drawn written into it."""

import random
from dataclasses import replace

import pytest

from roadmend.core.errors import InputError
from roadmend.safe.casting import WAITED_FOR
from roadmend.safe.construction import build_scenario, draw_scenario
from roadmend.safe.dsl import DescribedCollision, DescribedEnvironment, Manoeuvre, Side, Time, Weather
from roadmend.safe.open_questions import open_questions
from roadmend.world.scenario_actors import Drift, Follow, Heedless
from roadmend.world.scenario_file import load_scenario, save_scenario
from roadmend.world.simulation import Simulation
from roadmend.world.space import sample

from .crashes import ALL, CROSSING, HEAD_ON, crash, role, vehicle


@pytest.mark.parametrize("name", ALL)
def test_every_vehicle_can_be_the_ego_and_nobody_starts_inside_another(name, tmp_path):
    what = ALL[name]
    for ego in range(len(what.vehicles)):
        scenario = draw_scenario(role(what, ego), 0)
        save_scenario(scenario, tmp_path / "s.yaml")
        assert load_scenario(tmp_path / "s.yaml") == scenario
        with Simulation(scenario) as simulation:
            tick = simulation.first()
            assert tick.final is None
            assert tick.min_distance > 0.5
        others = {f"v{n + 1}" for n in range(len(what.vehicles)) if n != ego}
        assert {actor.id for actor in scenario.actors} <= others | {WAITED_FOR}


def test_the_same_seed_gives_the_same_scenario_and_another_does_not():
    assert draw_scenario(role(CROSSING), 1) == draw_scenario(role(CROSSING), 1)
    assert draw_scenario(role(CROSSING), 1) != draw_scenario(role(CROSSING), 2)
    assert draw_scenario(role(CROSSING), 1) != draw_scenario(role(CROSSING), 1, seed=1)


def test_what_the_report_leaves_open_stands_in_the_scenario():
    origin = draw_scenario(role(ALL["open"]), 0).origin
    assert origin.report == "sample"
    for name in ("road_type", "lanes", "time", "weather", "v1.model", "v1.position", "v2.action", "v2.speed_limit"):
        assert name in origin.sampled
    said = draw_scenario(role(CROSSING), 0).origin.sampled
    assert not {"road_type", "lanes", "time", "weather", "v1.model", "v1.position", "v1.speed_limit"} & said.keys()


def test_light_weather_and_bodies_are_the_reports():
    dark = DescribedEnvironment(Time.NIGHTTIME, Weather.SNOWY)
    what = crash("Intersection", vehicle(), vehicle("S2N", model="Semi Truck"), environment=dark)
    scenario = draw_scenario(role(what), 0)
    assert (scenario.environment.weather, scenario.environment.time_of_day) == ("snowy", "nighttime")
    assert scenario.environment.effective_friction < 0.5
    assert scenario.actors[0].kind == "semi_truck"
    assert draw_scenario(role(what, 1), 0).ego.length > 15.0


def test_who_enters_the_wrong_way_comes_over_the_centre_line_and_the_other_does_not():
    def drifts(ego):
        (actor,) = draw_scenario(role(HEAD_ON, ego), 0).actors
        return [each for each in actor.manoeuvres if isinstance(each, Drift)]

    (drift,) = drifts(0)
    assert drift.offset == pytest.approx(3.2)
    assert drifts(1) == []


def test_a_parked_vehicle_stands_in_the_egos_lane():
    scenario = draw_scenario(role(ALL["parked"]), 0)
    (actor,) = scenario.actors
    assert (actor.lane, actor.speed) == (scenario.ego.lane, 0.0)
    assert actor.manoeuvres == [Heedless(when=actor.manoeuvres[0].when, speed=0.0)]
    assert actor.position > scenario.ego.position


def test_who_had_stopped_stands_behind_somebody_and_that_is_said():
    scenario = draw_scenario(role(ALL["parked"], 1), 0)
    ahead, behind = scenario.actors
    assert (ahead.id, ahead.speed, scenario.ego.speed) == (WAITED_FOR, 0.0, 0.0)
    assert ahead.position - 4.6 > scenario.ego.position
    assert behind.lane == ahead.lane == scenario.ego.lane
    assert "stands before the ego" in scenario.origin.adapted[0]


def test_who_has_no_room_on_its_road_is_said_to_be_left_out():
    chain = crash("Intersection", vehicle(), vehicle(manoeuvre="Stop"), vehicle(manoeuvre="Stop"),
                  collisions=[DescribedCollision(1, 2), DescribedCollision(2, 3)])  # fmt: skip
    gone = 0
    for ego in range(3):
        for index in range(6):
            scenario = draw_scenario(role(chain, ego), index)
            missing = {f"v{n + 1}" for n in range(3) if n != ego} - {actor.id for actor in scenario.actors}
            told = {text for text in scenario.origin.adapted if "left out" in text}
            assert told == {f"vehicle {name[1:]}: no room on its road, left out" for name in missing}
            gone += len(missing)
    assert gone


def test_who_turns_at_a_junction_drives_along_a_line_of_its_own():
    what = crash("Intersection", vehicle("W2E"), vehicle("E2W", "Turn Left"))
    (actor,) = draw_scenario(role(what), 0).actors
    follow = actor.manoeuvres[-1]
    assert isinstance(follow, Follow)
    assert follow.points[0][0] > 200.0
    assert follow.points[-1][1] < -200.0
    assert follow.speed < 9.0


@pytest.mark.parametrize(
    ("manoeuvre", "sides", "offsets"),
    [
        ("Changing Lane", (Side.FRONT, Side.LEFT), [3.2]),
        ("Changing Lane", (Side.FRONT, Side.RIGHT), [-3.2]),
        (None, (Side.FRONT, Side.LEFT), [3.2]),
    ],
)
def test_who_was_struck_on_its_left_came_from_the_right(manoeuvre, sides, offsets):
    what = crash("Straight", vehicle(), vehicle(manoeuvre=manoeuvre), lanes=6,
                 collisions=[DescribedCollision(1, 2, *sides)])  # fmt: skip
    what = replace(what, vehicles=(replace(what.vehicles[0], extras={"x-lane": "middle"}), what.vehicles[1]))
    (actor,) = draw_scenario(role(what), 0).actors
    assert [each.offset for each in actor.manoeuvres if isinstance(each, Drift)] == offsets


def test_a_u_turn_and_a_way_backwards_are_lines():
    for word in (Manoeuvre.U_TURN, Manoeuvre.REVERSE):
        told = replace(vehicle(), manoeuvre=word)
        (actor,) = draw_scenario(role(crash("Straight", vehicle(), told)), 0).actors
        follow = actor.manoeuvres[-1]
        assert isinstance(follow, Follow)
        assert follow.backwards == (word is Manoeuvre.REVERSE)
        assert follow.points[-1][0] < follow.points[0][0]


def test_who_strikes_from_behind_starts_behind_and_is_faster():
    (ahead,) = draw_scenario(role(ALL["rear end"], 0), 0).actors
    scenario = draw_scenario(role(ALL["rear end"], 1), 0)
    (behind,) = scenario.actors
    assert behind.speed > scenario.ego.speed
    assert behind.depart > 0.0 or behind.position < scenario.ego.position
    assert ahead.position > draw_scenario(role(ALL["rear end"], 0), 0).ego.position


def test_points_instead_of_an_action_count_as_the_turn_that_they_make():
    points = ((0.0, 0.0), (20.0, 0.0), (25.0, 20.0))
    scenario = draw_scenario(role(crash("Intersection", vehicle("W2E", points), vehicle("S2N"))), 0)
    assert scenario.ego.route == ["west_in", "north_out"]


def test_a_name_keeps_to_what_a_scenario_may_be_called():
    drawn = sample(open_questions(CROSSING), random.Random(1))
    assert build_scenario(role(CROSSING), drawn, "caseé 7/8", 0).name == "case--7-8"


def test_a_merge_that_was_drawn_for_a_vehicle_with_a_compass_direction_is_refused():
    what = crash(None, vehicle("W2E"), vehicle("S2N"))
    drawn = sample(open_questions(what), random.Random(1)) | {"road_type": "Merging"}
    with pytest.raises(InputError, match="initial_position"):
        build_scenario(role(what), drawn, "x", 0)
