"""A vehicle that crashes alone does so physically and as described, before an ego that is none of the report's."""

import math
import random
from dataclasses import replace

import pytest

from roadmend.safe.construction import build_scenario, draw_scenario, roles_of
from roadmend.safe.described_crash import record_of
from roadmend.safe.dsl import Weather
from roadmend.safe.judge import judge
from roadmend.safe.likeness import Likeness
from roadmend.safe.motion import LATERAL_BOUND
from roadmend.safe.open_questions import open_questions
from roadmend.safe.run_map import beside_its_way, is_on_roadway
from roadmend.safe.trial import run_trial
from roadmend.world.scenario_actors import Follow, Heedless, Trigger
from roadmend.world.scenario_file import load_scenario, save_scenario
from roadmend.world.space import sample

from .crashes import HEAD_ON
from .lone import LONE, lone, onlooker

ON_THE_ROAD = {"animal"}


def drawn(what, seed=1, **fixed):
    point = sample(open_questions(what), random.Random(seed)) | fixed
    return build_scenario(onlooker(what), point, "s", 0)


@pytest.mark.parametrize("name", LONE)
def test_it_strikes_what_the_report_says_within_physical_bounds(name, tmp_path):
    what = LONE[name]
    scenario = drawn(what)
    save_scenario(scenario, tmp_path / "s.yaml")
    assert load_scenario(tmp_path / "s.yaml") == scenario
    trial = run_trial(scenario, "modular")
    (thing,) = scenario.obstacles
    first = trial.contact
    assert first.names == {"v1", thing.id}
    assert first.of("v1").speed > 3.0
    assert trial.run.motions["v1"].lateral < LATERAL_BOUND
    assert is_on_roadway(scenario.network, first.x, first.y) is (name in ON_THE_ROAD)
    assert is_on_roadway(scenario.network, thing.x, thing.y) is (name in ON_THE_ROAD)
    found = judge(trial.run, record_of(what))
    assert {str(each) for each in found.failed} <= {"order"}  # the ego may run into the wreck


@pytest.mark.parametrize("name", ["right", "left", "bend", "inside", "unsaid"])
def test_it_leaves_to_the_side_that_is_said_else_to_the_outside_of_a_bend_else_to_the_right(name):
    scenario = drawn(LONE[name])
    (thing,) = scenario.obstacles
    is_left = beside_its_way(scenario, "v1", thing.x, thing.y) > 0.0
    assert is_left is (name in {"left", "bend"})


def test_the_wreck_stays_where_it_struck():
    trial = run_trial(drawn(LONE["right"]), "modular")
    track = trial.film.track("v1")
    after = track[track[:, 0] > trial.contact.tick + 1]
    assert len(after) > 20
    assert math.hypot(*(after[0, 1:3] - after[-1, 1:3])) < 0.01


def test_a_vehicle_that_simply_drives_on_reproduces_nothing():
    what = LONE["right"]
    scenario = drawn(what)
    (actor,) = scenario.actors
    goes_on = [Heedless(when=Trigger(time=0.0), speed=actor.speed)]
    control = scenario.model_copy(update={"actors": [actor.model_copy(update={"manoeuvres": goes_on})]})
    found = judge(run_trial(control, "modular").run, record_of(what))
    assert {*found.failed} == {*Likeness}


def test_who_looks_on_drives_behind_or_comes_the_other_way_and_that_is_said():
    behind = drawn(LONE["right"], **{"onlooker": "behind", "onlooker.gap": 2.0})
    (actor,) = behind.actors
    assert behind.ego.route == actor.route
    gap = actor.position - 4.6 - (behind.ego.position + 0.5 * behind.ego.length)
    assert gap == pytest.approx(2.0 * actor.speed, abs=0.2)
    assert behind.origin.vehicle is None
    assert "no vehicle of the report: it drives behind" in behind.origin.adapted[-1]
    other = drawn(LONE["right"], onlooker="oncoming")
    assert other.ego.route == ["backward"]
    assert "comes the other way" in other.origin.adapted[-1]
    assert run_trial(other, "modular").contact.names == {"v1", "tree"}
    alone = lone("Straight", lanes=1, roadside="Right")  # no lane for anybody who comes the other way
    assert drawn(alone, onlooker="oncoming").ego.route == ["forward"]


def test_on_a_slippery_road_and_in_haste_it_still_keeps_to_physics():
    what = LONE["inside"]
    snow = replace(what, environment=replace(what.environment, weather=Weather.SNOWY))
    trial = run_trial(drawn(snow, **{"v1.speed": 1.25}), "modular")
    assert trial.contact.names == {"v1", "tree"}
    assert trial.is_physical


def test_what_was_struck_may_be_unsaid():
    scenario = drawn(lone(thing=None))
    assert scenario.obstacles[0].kind == "object"
    assert "what was struck is not said" in scenario.origin.adapted[-1]


def test_a_road_too_wide_to_come_off_is_said():
    told = set()
    for index in range(6):
        scenario = draw_scenario(onlooker(lone(lanes=8, roadside="Left")), index)
        (tree,) = scenario.obstacles
        is_said = "the tree stands on the roadway" in scenario.origin.adapted[-1]
        assert is_said is is_on_roadway(scenario.network, tree.x, tree.y)
        told.add(is_said)
    assert told == {True, False}


def test_one_vehicle_alone_has_an_onlooker_and_several_have_none():
    assert [role.name for role in roles_of("a", LONE["right"])] == ["onlooker"]
    assert [role.name for role in roles_of("a", HEAD_ON)] == ["v1", "v2"]
    assert draw_scenario(onlooker(LONE["right"]), 0).name == "sample-onlooker-0"
    (follow,) = drawn(LONE["right"]).actors[0].manoeuvres
    assert isinstance(follow, Follow)
