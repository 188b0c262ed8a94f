import math

import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.repair.parameters import RuleParameters
from roadmend.repair.rule import RuleRepair

from .playground import Box, curved_route, ego_at, keep_on, scene_of, straight_route


def propose(boxes, *, ego=None, route=None, decision=None, **parameters):
    method = RuleRepair(RuleParameters(**parameters))
    method.reset(route or straight_route())
    scene = scene_of(boxes, ego=ego)
    return method.propose(scene, decision or keep_on(scene))


def steps_in(proposal) -> bool:
    return proposal.score > proposal.threshold


@pytest.mark.parametrize("gap", [0.0, 1.0, 10.0, 29.0, 29.9, 30.1, 31.0, 50.0])
def test_it_brakes_below_the_threshold_and_not_above(gap):
    proposal = propose([Box(5, gap + 4.5, 0.0)])
    assert steps_in(proposal) == (gap < 30.0)
    assert proposal.score == pytest.approx(1.0 / (1.0 + gap / 10.0))
    if gap < 30.0:
        assert proposal.action == -1.0
        assert proposal.triggers[0].object_id == 5
        assert f"{gap:.1f} m" in proposal.reason


@pytest.mark.parametrize("speed", [10.0, 12.0])
def test_who_does_not_close_in_is_no_concern(speed):
    assert not steps_in(propose([Box(1, 8.0, 0.0, speed=speed)]))


@pytest.mark.parametrize("y", [2.1, -2.1, 3.5])
def test_who_stands_beside_the_swath_is_no_concern(y):
    assert not steps_in(propose([Box(1, 15.0, y)]))


def test_who_is_behind_is_no_concern():
    assert not steps_in(propose([Box(1, -8.0, 0.0, speed=20.0)]))


def test_the_nearest_decides():
    assert not steps_in(propose([Box(1, 12.0, 0.0, speed=10.0), Box(2, 25.0, 0.0)]))


def test_ahead_means_along_the_curved_path():
    ego = ego_at(-5.0)
    bare = Decision(Command(0.2, 0.0), Trajectory.empty())
    around_the_corner = Box(1, 20.0, 22.0, 0.5 * math.pi)
    straight_ahead = Box(2, 22.0, -4.0)
    assert steps_in(propose([around_the_corner], ego=ego, route=curved_route(), decision=bare, time_to_collision=5.0))
    assert not steps_in(propose([straight_ahead], ego=ego, route=curved_route(), decision=bare, time_to_collision=5.0))


def test_a_bus_across_the_road_counts_by_its_length():
    assert steps_in(propose([Box(1, 20.0, 5.0, 0.5 * math.pi, length=12.0)]))
    assert not steps_in(propose([Box(1, 20.0, 5.0, 0.0, length=12.0)]))


@pytest.mark.parametrize(("gap", "action"), [(29.0, -0.4), (12.0, -0.6), (8.0, -0.8), (6.3, -1.0), (0.0, -1.0)])
def test_graded_it_brakes_as_much_as_the_gap_needs(gap, action):
    assert propose([Box(1, gap + 4.5, 0.0)], graded=True).action == action
