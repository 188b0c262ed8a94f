"""Pulses and patience: a choice holds as it was tried, is judged anew, and lets go of what does not pass."""

import numpy as np
import pytest
from pydantic import ValidationError

from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.configuration import Deciding
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.patience import Patience
from roadmend.repair.parameters import AdreftParameters

from .playground import Box, ego_at, keep_on, scene_of, straight_route
from .tiny_model import save_tiny_model

TICK = 0.05  # [s]
FULL, IDLE = ACTIONS.index(-1.0), 0


@pytest.fixture
def drive(tmp_path, monkeypatch):
    """Plays a script of scores and best choices; returns for every tick whether it brakes, and the proposals."""

    def play(scores, choices=None, speed=5.0, asked=0.5, **configuration):
        path = save_tiny_model(tmp_path / "model.safetensors", threshold=0.5, **configuration)
        method = AdreftRepair(AdreftParameters(model=str(path)))
        method.reset(straight_route())
        proposals = []
        for number, score in enumerate(scores):
            choice = FULL if choices is None else choices[number]
            values = np.eye(1, len(ACTIONS), choice, dtype=np.float32)[0]
            monkeypatch.setattr(AdreftModel, "score", lambda *_, score=score: score)
            monkeypatch.setattr(AdreftModel, "values", lambda *_, values=values: values)
            now = speed(number) if callable(speed) else speed
            scene = scene_of([Box(1, 20.0, 0.0)], number * TICK, ego_at(speed=now))
            proposals.append(method.propose(scene, keep_on(scene, action=asked)))
        return [each.score > each.threshold and each.action < asked for each in proposals], proposals

    return play


PULSE = {"interval": 12, "hold": 0.6, "fresh": True}


def test_a_pulse_lasts_as_it_was_tried_though_the_score_falls_at_once(drive):
    braking, _ = drive([0.1] * 5 + [0.9] + [0.1] * 30, **PULSE)
    assert braking == [False] * 5 + [True] * 12 + [False] * 19


def test_a_pulse_begins_with_the_choice_of_its_own_tick(drive):
    scores = [0.1] * 5 + [0.9] * 12 + [0.1] * 5
    choices = [IDLE] * 5 + [FULL] + [4] * 30
    _, proposals = drive(scores, choices, **PULSE)
    assert [each.action for each in proposals[5:17]] == [-1.0] * 12
    _, stale = drive(scores, choices, **{**PULSE, "fresh": False})
    assert stale[5].action == ACTIONS[IDLE]


def test_an_opening_brakes_in_full_before_the_choice_is_asked(drive):
    _, proposals = drive([0.1] * 2 + [0.9] * 6 + [0.1], [4] * 9, opening=0.2)
    assert [each.action for each in proposals] == [ACTIONS[4]] * 2 + [-1.0] * 4 + [ACTIONS[4]] * 3
    assert ["in full at first" in each.reason for each in proposals] == [False] * 2 + [True] * 4 + [False] * 3


def test_an_ego_that_stands_is_held_no_harder_than_its_model_says(drive):
    def tried(**configuration):
        stops = [2.0] * 3 + [0.0] * 3
        return drive([0.9] * 6, [FULL] * 4 + [7, IDLE], speed=stops.__getitem__, **configuration)

    braking, proposals = tried(holding=-0.2)
    assert [each.action for each in proposals] == [-1.0] * 3 + [-0.2, -0.2, ACTIONS[IDLE]]
    assert ACTIONS[7] < -0.2
    assert braking == [True] * 5 + [False]
    assert ["held where it stands" in each.reason for each in proposals] == [False] * 3 + [True] * 2 + [False]
    assert [each.action for each in tried()[1]] == [-1.0] * 4 + [ACTIONS[7], ACTIONS[IDLE]]
    braking, proposals = drive([0.9] * 6, speed=0.0, opening=0.1, holding=-0.4)
    assert [each.action for each in proposals] == [-0.4] * 6
    assert all(braking)
    _, proposals = drive([0.1] * 3, speed=0.0, holding=-0.2)  # nothing is held where nothing is due
    assert [each.reason for each in proposals] == [""] * 3


@pytest.mark.parametrize("holding", [-0.3, -0.1, -1.2])
def test_what_holds_is_one_of_the_actions_that_brake(holding):
    with pytest.raises(ValidationError):
        Deciding(holding=holding)


def test_after_a_pulse_the_choice_is_made_anew(drive):
    choices = [FULL] * 6 + [4] * 12 + [5] * 40
    braking, proposals = drive([0.9] * 40, choices, **PULSE)
    assert all(braking)
    assert [each.action for each in proposals] == [-1.0] * 12 + [ACTIONS[4]] * 12 + [ACTIONS[5]] * 16


def test_short_intervals_judge_anew_within_the_hold_and_keep_the_last_choice_to_its_end(drive):
    choices = [FULL] * 4 + [4] * 4 + [5] * 40
    braking, proposals = drive([0.9] * 9 + [0.1] * 20, choices, interval=4, hold=0.6)
    assert braking == [True] * 12 + [False] * 17
    assert [each.action for each in proposals[:12]] == [-1.0] * 4 + [ACTIONS[4]] * 4 + [ACTIONS[5]] * 4


def test_where_no_braking_pays_nothing_is_held_and_the_next_tick_is_judged_again(drive):
    braking, _ = drive([0.9] * 20, [IDLE] * 3 + [FULL] * 17, **PULSE)
    assert braking == [False] * 3 + [True] * 17
    braking, _ = drive([0.9] * 40, [FULL] * 12 + [IDLE] * 5 + [FULL] * 23, **PULSE)
    assert braking == [True] * 12 + [False] * 5 + [True] * 23


def test_an_intervention_that_does_not_pass_is_let_go_until_the_score_falls(drive):
    scores = [0.8] * 60 + [0.4] + [0.8] * 10
    braking, proposals = drive(scores, longest=1.0)
    assert braking == [True] * 21 + [False] * 40 + [True] * 10  # 20 intervals of 0.05 s are a second
    assert proposals[30].threshold == pytest.approx(0.9)
    assert proposals[30].reason == "let go until the score falls to 0.500"
    assert proposals[-1].threshold == 0.5
    assert all(drive(scores[:60])[0])


def test_a_score_that_rises_further_stops_it_again_and_the_bar_goes_up_once(drive):
    scores = [0.8] * 40 + [0.95] * 60 + [0.85] * 10
    braking, proposals = drive(scores, longest=1.0)
    assert braking == [True] * 21 + [False] * 19 + [True] * 60 + [False] * 10
    assert {each.threshold for each in proposals[21:]} == {proposals[21].threshold}


def test_standing_too_long_is_let_go_and_driving_slowly_is_not(drive):
    braking, _ = drive([0.8] * 60, standstill=1.0, speed=lambda tick: 0.0 if tick >= 20 else 2.0)
    assert braking == [True] * 40 + [False] * 20
    assert all(drive([0.8] * 60, standstill=1.0, speed=0.5)[0])


def test_standing_without_an_intervention_costs_no_patience(drive):
    braking, _ = drive([0.8] * 80, asked=-1.0, speed=0.0, standstill=1.0, longest=1.0)
    assert not any(braking)
    choices = [IDLE] * 40 + [FULL] * 40
    braking, _ = drive([0.8] * 80, choices, speed=0.0, standstill=1.0, longest=10.0)
    assert braking == [False] * 40 + [True] * 21 + [False] * 19


def test_a_new_episode_begins_with_all_patience():
    patience = Patience(0.1, 0.0)
    for number in range(4):
        patience.watch(scene_of([], number * TICK), intervenes=True)
    assert patience.bar(0.6, 0.5) == pytest.approx(0.8)
    assert patience.has_ended
    patience.reset()
    assert patience.bar(0.6, 0.5) == 0.5


def test_time_that_nobody_saw_does_not_count():
    patience = Patience(1.0, 1.0)
    for time in (0.0, 5.0, 4.0, 4.05):
        patience.watch(scene_of([], time, ego_at(speed=0.0)), intervenes=True)
    assert patience.bar(0.6, 0.5) == 0.5
