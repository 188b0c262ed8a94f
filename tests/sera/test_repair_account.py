"""What the repair node did about failures and in interventions, read from hand-made recordings."""

import numpy as np
import pytest

from roadmend.core.outcome import Blame
from roadmend.core.repair import RepairStatus
from roadmend.sera.repair_account import (
    Intervention,
    account_of_failure,
    account_of_intervention,
    account_of_standstill,
    interventions_of,
    plan_gap,
)

from .recorded import TICK_NS, ego, episode, repair, straight_plan, track

FRONT = Blame.FRONT
EGOS = [ego(0.5 * number) for number in range(200)]
END = 199 * TICK_NS


def braking(*ticks, brake=-1.0):
    return {tick: repair(0.5, brake) for tick in ticks}


def failure(repairs, blame=FRONT, avoidable=1.0, method="rss"):
    return account_of_failure(episode(EGOS, repairs=repairs, method=method), END, blame, avoidable)


@pytest.mark.parametrize(
    ("repairs", "blame", "avoidable", "method", "verdict"),
    [
        ({}, FRONT, 1.0, "", "no_method"),
        (None, FRONT, 1.0, "none", "no_method"),
        (None, FRONT, 1.0, "rss", "not_at_all"),
        (braking(*range(185, 199)), FRONT, 1.0, "rss", "too_late"),
        (braking(*range(150, 199)), FRONT, None, "rss", "too_late"),
        (braking(*range(179, 199), brake=-0.1), FRONT, 1.0, "rss", "too_weak"),
        (braking(*range(170, 199)), Blame.REAR, None, "rss", "struck_while_braking"),
        (braking(*range(170, 199)), Blame.EGO_STOOD, None, "rss", "struck_while_braking"),
        (braking(*range(10)), FRONT, 1.0, "rss", "not_at_all"),  # long before
    ],
)
def test_before_a_collision_it_was_absent_late_weak_or_harmful(repairs, blame, avoidable, method, verdict):
    assert failure(repairs, blame, avoidable, method).verdict == verdict


def test_the_account_says_which_states_held_how_long_and_what_was_changed():
    found = failure(braking(190, 191, 195))
    assert [name for name, _ in found.states] == ["PASS", "REPAIRED", "PASS", "REPAIRED", "PASS"]
    assert sum(length for _, length in found.states) == pytest.approx(8.0)
    assert (found.begin, found.frames, found.dose) == (9.5, 3, pytest.approx(3 * 1.5 * 0.05))


def test_ticks_without_a_word_of_the_node_are_silent():
    made = episode(EGOS, repairs=braking(190))
    for tick in range(195, 199):
        del made.repairs[tick * TICK_NS]
    assert account_of_failure(made, END, FRONT, 1.0).states[-1][0] == "SILENT"


@pytest.mark.parametrize(
    ("speed", "repairs", "verdict"),
    [
        (0.0, braking(*range(60, 199), brake=0.0), "held_the_ego"),
        (0.0, braking(*range(190, 199), brake=0.0), "not_involved"),
        (5.0, braking(*range(60, 199), brake=0.0), "not_involved"),
        (0.0, {}, "no_method"),
    ],
)
def test_before_a_time_out_it_held_the_ego_or_did_not(speed, repairs, verdict):
    made = episode([ego(speed=speed)] * 200, repairs=repairs)
    assert account_of_standstill(made, END).verdict == verdict


def test_interventions_end_with_a_pause_and_start_up_and_the_last_answer_are_none():
    held = {number: repair(0.5, 0.0, RepairStatus.STARTING) for number in range(5)}
    made = episode(EGOS, repairs=held | braking(20, 21, 30, 50))
    made.repairs[END] = repair(0.5, -1.0)
    tick = TICK_NS
    assert [*interventions_of(made)] == [Intervention(20 * tick, 30 * tick), Intervention(50 * tick, 50 * tick)]


@pytest.mark.parametrize(
    ("gap", "status", "verdict"),
    [
        (0.0, RepairStatus.REPAIRED, "needed"),
        (0.5, RepairStatus.REPAIRED, "close"),
        (3.0, RepairStatus.REPAIRED, "no_need_seen"),
        (None, RepairStatus.REPAIRED, "no_need_seen"),
        (0.0, RepairStatus.STALE_COMMAND, "controlled_stop"),
    ],
)
def test_an_intervention_is_judged_by_the_plan_or_was_for_missing_inputs(gap, status, verdict):
    made = episode(EGOS, repairs={20: repair(0.5, -1.0, status)})
    assert account_of_intervention(made, Intervention(20 * TICK_NS, 20 * TICK_NS), gap).verdict == verdict


def test_the_plan_is_held_against_where_the_others_were_then():
    ticks = np.arange(100)
    ahead = track(30.0 + 5.0 * ticks / 20, 0.0, 0.0, 5.0)
    egos = [ego(0.2 * tick) for tick in ticks]
    meets = episode(egos, [ahead], plan=straight_plan(15.0))
    assert plan_gap(meets, 0) == (0.0, 7)
    slow = episode(egos, [ahead], plan=straight_plan(5.0))
    assert plan_gap(slow, 0)[0] == pytest.approx(26.0, abs=1.0)


def test_who_comes_from_behind_is_not_what_the_plan_runs_into():
    chaser = track(-10.0 + np.arange(100), 0.0, 0.0, 20.0)
    assert plan_gap(episode([ego()] * 100, [chaser], plan=straight_plan(2.0)), 0) is None


def test_without_a_plan_nothing_is_said():
    assert plan_gap(episode(EGOS, [track(30.0, 0.0, 0.0, np.zeros(200))]), 0) is None
