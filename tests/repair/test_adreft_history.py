"""What the last second and the drive so far add to the tokens of a tick."""

from dataclasses import replace

import numpy as np
import pytest

import roadmend.repair.adreft.history as history_module
from roadmend.repair.adreft.history import (
    ASKED,
    ATTRIBUTES,
    BRIEFLY,
    DRIFT,
    FARTHEST,
    HARDEST,
    LATELY,
    LONG,
    OWN,
    SEEN,
    History,
)
from roadmend.repair.adreft.tokenizer import TokenSet

from .playground import TICK, Box, ego_at, keep_on, scene_of

COLUMNS = 3  # of the tokens of a tick, whatever they say


def tokens_of(scene):
    """A token of every participant, one of the plan, one of the ego."""
    rows = np.array([*range(len(scene.objects)), -1, -1], dtype=np.int32)
    return TokenSet(np.full((len(rows), COLUMNS), 7.0, dtype=np.float32), rows)


def extended(scenes, asked=0.25, history=None):
    """The columns added to the tokens of the last scene, after all of them were seen."""
    history = history or History()
    for scene in scenes:
        history.see(scene, keep_on(scene, action=asked))
    values = history.extend(tokens_of(scenes[-1]))
    assert values.dtype == np.float32
    assert (values[:, :COLUMNS] == 7.0).all()
    return values[:, COLUMNS:]


def drive(boxes_at, seconds, ego_at_time=lambda _time: ego_at()):
    times = [number * TICK for number in range(round(seconds / TICK) + 1)]
    return [scene_of(boxes_at(time), time, ego_at_time(time)) for time in times]


def test_the_first_tick_knows_of_nothing_before():
    added = extended(drive(lambda _: [Box(1, 30.0, 0.0, speed=9.0)], 0.0))
    assert added.shape == (3, ATTRIBUTES)
    assert added[0].tolist() == [0.0] * ATTRIBUTES
    assert added[1].tolist() == [0.0] * ATTRIBUTES
    assert added[2].tolist() == pytest.approx([0.0, 0.25, 0.2, 0.0])


def test_an_acceleration_is_told_over_half_a_second_and_over_one():
    def speed(time):  # 2 m/s2 at first, -4 m/s2 in the last half second
        return 8.0 + 2.0 * min(time, 1.0) - 4.0 * max(0.0, time - 1.0)

    added = extended(drive(lambda time: [Box(1, 30.0, 0.0, speed=speed(time))], 1.5))
    assert added[0, BRIEFLY] == pytest.approx(-4.0 / 4.0)
    assert added[0, LATELY] == pytest.approx((-4.0 * 0.5 + 2.0 * 0.5) / 1.0 / 4.0)


@pytest.mark.parametrize("yaw", [0.0, 2.0, -3.0])
def test_a_drift_is_told_across_the_own_heading_to_the_left_however_the_road_lies(yaw):
    def boxes(time):
        along, left = 10.0 * time, 0.8 * time
        x, y = along * np.cos(yaw) - left * np.sin(yaw), along * np.sin(yaw) + left * np.cos(yaw)
        return [Box(4, x, y, yaw=yaw, speed=10.0)]

    assert extended(drive(boxes, 1.0))[0, DRIFT] == pytest.approx(0.8 / 2.0)


def test_who_has_just_come_into_sight_is_told_from_who_has_long_been_there():
    def boxes(time):
        return [Box(9, 50.0, 0.0, speed=5.0), *([Box(2, 40.0, 3.0, speed=5.0)] if time > 1.99 else [])]

    added = extended(drive(boxes, 2.5))
    assert added[:2, SEEN].tolist() == pytest.approx([0.5, 0.1])
    assert added[1, LATELY] == 0.0


def test_the_farthest_that_was_seen_and_the_hardest_that_brakes_have_bitten_are_remembered():
    def ego(time):
        return ego_at(speed=12.0 - 6.0 * min(1.0, max(0.0, time - 1.0)))

    added = extended(drive(lambda time: [Box(1, 90.0 - 40.0 * time, 0.0)], 4.0, ego), asked=-1.0)
    assert added[-1, FARTHEST] == pytest.approx(90.0 / 150.0)
    assert added[-1, HARDEST] == pytest.approx(6.0 / 4.0)
    assert added[-1, OWN] == 0.0
    assert added[-1, ASKED] == -1.0
    within = extended(drive(lambda _: [], 1.5, ego))
    assert within[-1, OWN] == pytest.approx(-3.0 / LONG / 4.0)


@pytest.mark.parametrize("shift", [-1.0, 5.0])
def test_a_jump_of_the_clock_begins_anew(shift):
    scenes = drive(lambda _: [Box(1, 90.0, 0.0)], 1.0, lambda time: ego_at(speed=10.0 - 5.0 * time))
    jumped = scene_of([Box(1, 20.0, 0.0)], 1.0 + shift, ego_at(speed=3.0))
    added = extended([*scenes, jumped])
    assert added[0].tolist() == [0.0] * ATTRIBUTES
    assert added[-1].tolist() == pytest.approx([0.0, 0.25, 20.0 / 150.0, 0.0])


def test_a_new_episode_forgets_the_one_before():
    history = History()
    scenes = drive(lambda _: [Box(1, 90.0, 0.0)], 1.0)
    extended(scenes, history=history)
    history.reset()
    assert extended([replace(scenes[0], time=0.0)], history=history)[0].tolist() == [0.0] * ATTRIBUTES


def test_in_a_drive_of_hours_those_out_of_sight_are_forgotten(monkeypatch):
    monkeypatch.setattr(history_module, "_MOST", 3)
    scenes = [scene_of([Box(1, 20.0, 0.0), Box(2 + number, 50.0, 0.0)], number * 1.0) for number in range(9)]
    history = History()
    added = extended(scenes, history=history)
    assert len(history._first_seen) <= 3
    assert added[:2, SEEN].tolist() == [1.0, 0.0]  # who is still there is not


def test_nothing_swamps_the_model():
    def boxes(time):
        return [Box(1, 1.0e6 * time, -1.0e6 * time, speed=1.0e5 * time)]

    assert np.abs(extended(drive(boxes, 1.0))).max() <= 3.0
