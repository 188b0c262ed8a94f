"""While the ego changes lanes it is braked for those ahead alone: where a change begins and ends, and who is ahead."""

import math
from dataclasses import replace

import numpy as np
import pytest

from roadmend.core.command import Command, Decision
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.lane_change import ASIDE, LaneChange, time_to_front
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.registry import make_repairer

from .playground import TICK, Box, ego_at, keep_on, scene_of, straight_route, two_lane_route
from .tiny_model import save_tiny_model


@pytest.mark.parametrize(
    ("box", "time"),
    [
        (Box(1, 25.0, 0.0, speed=5.0), (25.0 - 4.5 - 1.0) / 5.0),  # bumper to bumper less a metre, 5 m/s slower
        (Box(1, 25.0, 1.8 + ASIDE - 0.01, speed=5.0), 3.9),  # on the lane that the ego goes to
        (Box(1, 25.0, 1.8 + ASIDE, speed=5.0), math.inf),  # beyond it
        (Box(1, 25.0, 0.0, speed=10.0), math.inf),  # keeps its distance
        (Box(1, 5.0, 0.0, speed=20.0), 0.0),  # so near that its speed does not matter
        (Box(1, -5.0, 0.0, speed=20.0), math.inf),  # behind
        (Box(1, 25.0, 0.0, yaw=math.pi, speed=5.0), 1.3),  # comes towards the ego
        (Box(1, 25.0, 0.0, yaw=math.pi / 2.0, speed=5.0), 1.95),  # crosses
    ],
)
def test_times_by_hand(box, time):
    assert time_to_front(scene_of([box], ego=ego_at(speed=10.0))) == pytest.approx(time)


def test_the_first_of_several_counts_and_nobody_is_never():
    assert time_to_front(scene_of([], ego=ego_at(speed=10.0))) == math.inf
    both = [Box(1, 25.0, 0.0, speed=5.0), Box(2, 15.5, 0.0, speed=5.0)]
    assert time_to_front(scene_of(both, ego=ego_at(speed=10.0))) == pytest.approx(2.0)


def ways(offsets, *, begins_at=0):
    """Whether a change to the lane at 3.2 m is under way at each tick, given the ego's offset at each."""
    change = LaneChange(2.0)
    change.reset(two_lane_route())
    found = []
    for tick, offset in enumerate(offsets):
        scene = scene_of([], time=tick * TICK, ego=ego_at(x=0.5 * tick, y=offset))
        change.see(scene)
        found.append(change.is_under_way)
        if tick == begins_at:
            change.begin(scene)
    return found


def test_it_lasts_from_the_tick_after_the_wish_until_the_next_lane_is_reached():
    offsets = [0.0, 0.0, 0.1, 0.8, 1.6, 2.4, 2.89, 2.91, 3.2, 3.2]
    assert ways(offsets) == [False, *[True] * 6, False, False, False]


def test_an_ego_that_stands_across_two_lanes_is_still_changing():
    assert all(ways([0.0, *[1.5] * 600])[1:])


def test_a_change_that_does_not_begin_ends_by_itself():
    found = ways([0.0] * 60)
    assert found.count(True) == 29  # a second and a half, with the tick of the wish
    assert not found[-1]


def test_on_the_last_stage_there_is_nowhere_to_go():
    assert not any(ways([3.2] * 5))


@pytest.mark.parametrize(
    ("begin", "end", "expected"), [(100.0, 100.0, True), (90.0, 99.9, False), (100.1, 110.0, False)]
)
def test_a_change_begins_within_its_window_alone(begin, end, expected):
    change = LaneChange(2.0)
    change.reset(two_lane_route(begin, end))
    change.begin(scene_of([]))
    assert change.is_under_way is expected


def test_without_a_window_the_vehicle_ignores_the_wish():
    change = LaneChange(2.0)
    change.reset(replace(two_lane_route(), windows=()))
    change.begin(scene_of([]))
    assert not change.is_under_way


def test_a_clock_that_goes_back_ends_a_change_that_has_not_left_its_lane():
    change = LaneChange(2.0)
    change.reset(two_lane_route())
    for time in (5.0, 1.0):
        scene = scene_of([], time=time)
        change.see(scene)
        if time == 5.0:
            change.begin(scene)
    assert not change.is_under_way


def repairer_of(tmp_path, monkeypatch, **settings):
    """One that wants to brake hard at every tick."""
    values = np.eye(1, len(ACTIONS), len(ACTIONS) - 1, dtype=np.float32)[0]
    monkeypatch.setattr(AdreftModel, "values", lambda *_: values)
    path = save_tiny_model(tmp_path / "tiny.safetensors", threshold=0.0, **settings)
    return make_repairer("adreft", {"model": str(path)})


def run(repairer, route, boxes, *, change_lane):
    """Two ticks, at the first of which the policy asks for a lane change; returns what came of the second."""
    repairer.reset(route)
    scene = scene_of(boxes)
    decision = keep_on(scene, action=0.3)
    asks = Decision(Command.from_action(0.3, change_lane=change_lane), decision.trajectory)
    first = repairer.step(scene, asks)
    assert first.intervened
    return repairer.step(replace(scene, time=TICK), decision)


NEAR, FAR, BEHIND = Box(1, 20.0, 3.2, speed=0.0), Box(1, 60.0, 0.0, speed=8.0), Box(1, -12.0, 3.2, speed=18.0)


@pytest.mark.parametrize(
    ("boxes", "route", "change_lane", "brakes"),
    [
        ([BEHIND], two_lane_route(), True, False),
        ([FAR], two_lane_route(), True, False),
        ([NEAR, BEHIND], two_lane_route(), True, True),  # whoever is close ahead goes first
        ([BEHIND], two_lane_route(), False, True),  # no change under way
        ([BEHIND], straight_route(), True, True),  # no lane to change to
        ([BEHIND], two_lane_route(300.0, 400.0), True, True),  # its window is ahead: the vehicle ignores the wish
        ([BEHIND], two_lane_route(20.0, 90.0), True, True),  # its window is behind
    ],
)
def test_while_it_changes_lanes_it_is_braked_for_those_ahead_alone(
    tmp_path, monkeypatch, boxes, route, change_lane, brakes
):
    repair = run(repairer_of(tmp_path, monkeypatch, lane_change=2.0), route, boxes, change_lane=change_lane)
    assert repair.intervened == brakes
    assert ("the ego changes lanes and nobody is close ahead" in repair.reason) != brakes


def test_a_model_that_says_nothing_of_it_brakes_whenever_it_is_called_for(tmp_path, monkeypatch):
    assert run(repairer_of(tmp_path, monkeypatch), two_lane_route(), [BEHIND], change_lane=True).intervened


def test_a_change_that_is_held_back_does_not_begin(tmp_path, monkeypatch):
    repairer = repairer_of(
        tmp_path, monkeypatch, lane_change=2.0, change={"head": (6,), "threshold": 0.0, "horizon": 8.0}
    )
    assert run(repairer, two_lane_route(), [BEHIND], change_lane=True).intervened
