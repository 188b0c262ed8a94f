"""The described crash is found where it can happen, is the one described, and happens again from the file."""

import random

import pytest

from roadmend.core.outcome import EventKind
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.safe.described_crash import judge, why_not_played
from roadmend.safe.dsl import Collision, Side
from roadmend.safe.layout import lay_out
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.reproduction import reproduce
from roadmend.safe.trial import Contact, run_trial
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import load_scenario, save_scenario
from roadmend.world.space import sample

from .crashes import ALL, CROSSING, HEAD_ON, crash, role, vehicle

FRONT, REAR, LEFT = (frozenset({side}) for side in (Side.FRONT, Side.REAR, Side.LEFT))


def verdict(what, ego, contact):
    drawn = sample(open_questions(what), random.Random(5))
    return judge(what, lay_out(answer(what, drawn), drawn), ego, contact)


@pytest.mark.parametrize("name", ["straight", "rear end"])
def test_a_crash_is_found_and_its_file_shows_it_again(name, tmp_path):
    ego = {"straight": 0, "rear end": 1}[name]
    found = reproduce(role(ALL[name], ego), "modular", 30)
    assert found.is_reproduced, found.outcome
    save_scenario(found.scenario, tmp_path / "s.yaml")
    summary = run_episode(load_scenario(tmp_path / "s.yaml"), make_policy("modular"), make_repairer("none"))
    assert summary.outcome is EventKind.COLLISION
    assert summary.digest == found.trial.summary.digest
    again = reproduce(role(ALL[name], ego), "modular", 30)
    assert (again.episodes, again.scenario) == (found.episodes, found.scenario)


def test_who_is_alone_or_was_the_one_that_left_its_lane_is_not_tried():
    for what, ego, words in ((ALL["alone"], 0, "single vehicle"), (HEAD_ON, 1, "no policy is asked")):
        found = reproduce(role(what, ego), "modular", 30)
        assert (found.is_reproduced, found.episodes) == (False, 0)
        assert words in found.outcome
    three = crash("Straight", vehicle(), vehicle(), vehicle(), collisions=[Collision(1, 2)])
    assert "in no collision" in why_not_played(three, 2)
    merges = crash("Straight", vehicle(manoeuvre="Merge"), vehicle(), lanes=4)
    assert "no policy is asked" in why_not_played(merges, 0)
    assert why_not_played(ALL["merging"], 1) == ""


def test_a_budget_that_runs_out_says_how_near_it_came():
    found = reproduce(role(ALL["parked"], 0), "modular", 2)
    assert (found.is_reproduced, found.episodes) == (False, 2)
    assert "nearest" in found.outcome


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
    what = crash("Intersection", vehicle("W2E"), vehicle("S2N"), vehicle("S2N"), collisions=[Collision(2, 1)])
    found = verdict(what, 0, contact)
    assert not found.is_described
    assert words in found.reason


def test_who_had_stopped_must_stand_and_head_on_neither_is_the_one():
    stopped = crash("Straight", vehicle(), vehicle(manoeuvre="Stop"), collisions=[Collision(1, 2)])
    assert "had stopped" in verdict(stopped, 1, Contact("v1", REAR, FRONT, 0.0, 9.0, 0.0)).reason
    assert verdict(stopped, 1, Contact("v1", REAR, FRONT, 0.0, 0.2, 0.0)).is_described
    head_on = crash("Straight", vehicle("W2E"), vehicle("E2W"), collisions=[Collision(2, 1)])
    assert verdict(head_on, 0, Contact("v2", FRONT, FRONT, 178.0, 9.0, 0.0)).is_described


def test_the_sides_of_a_contact_are_those_that_touch():
    found = reproduce(role(ALL["rear end"], 1), "modular", 30)
    contact = run_trial(found.scenario, "modular").contact
    assert Side.REAR in contact.ego_sides
    assert Side.FRONT in contact.other_sides
    assert abs(contact.angle) < 15.0
