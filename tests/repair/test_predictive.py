import math
from itertools import pairwise

import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.parameters import PredictiveParameters
from roadmend.repair.predictive import PredictiveRepair

from .playground import FULL_BRAKE, TICK, Box, curved_route, drive, ego_at, keep_on, scene_of, straight_route

NORTH = 0.5 * math.pi


def method(**parameters) -> PredictiveRepair:
    return PredictiveRepair(PredictiveParameters(**parameters))


def propose(boxes, *, ego=None, route=None, decision=None, **parameters):
    made = method(**parameters)
    made.reset(route or straight_route())
    scene = scene_of(boxes, ego=ego)
    return made.propose(scene, decision or keep_on(scene))


def steps_in(proposal) -> bool:
    return proposal.score > proposal.threshold


def crossing(arrival: float, speed: float = 8.0, at: float = 30.0) -> Box:
    """Comes from the right; its centre is on the ego's line at x = ``at`` after ``arrival`` seconds."""
    return Box(9, at, -speed * arrival, NORTH, speed)


@pytest.mark.parametrize("gap", [5.0, 15.0, 29.0, 31.0, 50.0])
@pytest.mark.parametrize("horizon", [1.0, 3.0])
def test_contacts_within_the_horizon_count(gap, horizon):
    proposal = propose([Box(1, gap + 4.5, 0.0)], horizon=horizon)
    assert steps_in(proposal) == (gap - 0.3 <= 10.0 * horizon)
    if steps_in(proposal):
        time = math.ceil((gap - 0.3) / 1.0 - 1e-9) * 0.1
        assert proposal.score == pytest.approx(1.0 - time / (horizon + 0.1))
        assert proposal.triggers[0].object_id == 1


@pytest.mark.parametrize("y", [2.11, 3.5, -2.11])
def test_who_stands_beside_the_swath_is_no_contact(y):
    assert not steps_in(propose([Box(1, 15.0, y)]))


@pytest.mark.parametrize(("arrival", "meets"), [(0.0, False), (1.5, False), (2.9, True), (3.4, True), (5.0, False)])
def test_crossing_traffic_counts_if_it_is_there_at_the_same_time(arrival, meets):
    assert steps_in(propose([crossing(arrival)], horizon=4.0)) == meets


def test_a_follower_sees_to_itself():
    assert not steps_in(propose([Box(1, -7.0, 0.0, speed=20.0)]))


def test_a_follower_does_not_keep_the_ego_from_braking():
    alone = propose([Box(1, 20.0, 0.0)])
    followed = propose([Box(1, 20.0, 0.0), Box(2, -8.0, 0.0, speed=10.0)])
    assert followed.action == alone.action < 0.0


def test_simple_is_always_the_full_brake():
    assert propose([Box(1, 33.0, 0.0)], adaptive=False).action == -1.0


@pytest.mark.parametrize(("gap", "action"), [(29.0, -0.4), (14.5, -0.6), (9.0, -0.8), (6.9, -1.0)])
def test_adaptive_is_the_mildest_that_keeps_clear(gap, action):
    assert propose([Box(1, gap + 4.5, 0.0)]).action == pytest.approx(action)


def test_adaptive_brakes_little_for_one_who_only_has_to_pass_first():
    proposal = propose([crossing(2.6)])
    assert steps_in(proposal)
    assert -0.4 <= proposal.action < 0.0


def test_inside_a_conflict_zone_it_clears_instead_of_braking():
    """The other passes close behind the ego; who brakes now lets it come closer still."""
    proposal = propose([Box(4, -0.5, -8.0, NORTH, 15.0)], margin=1.5)
    assert steps_in(proposal)
    assert proposal.action == 0.2  # the policy's own action: nothing is replaced
    assert "going on" in proposal.reason


def test_where_nothing_keeps_clear_it_hits_as_slowly_as_it_can():
    proposal = propose([Box(1, 7.0, 0.0)])
    assert proposal.action == -1.0
    assert "no braking keeps clear" in proposal.reason


def test_turning_objects_are_followed_around_the_bend():
    turning = Box(1, 31.5, 8.0, math.pi, 8.0, yaw_rate=0.6)  # oncoming, turns left across the ego's lane
    assert steps_in(propose([turning]))
    assert not steps_in(propose([turning], turning=False))


def test_slowing_objects_stop_before_the_ego_if_told_to():
    slowing = Box(1, 22.0, -16.0, NORTH, 8.0, acceleration=-4.0)
    assert steps_in(propose([slowing], horizon=3.0))
    assert not steps_in(propose([slowing], horizon=3.0, slowing=True))


def test_without_a_plan_the_route_is_rolled_forward_at_the_present_speed():
    bare = Decision(Command(0.2, 0.0), Trajectory.empty())
    corner = Box(1, 20.0, 20.0, NORTH)
    assert steps_in(propose([corner], ego=ego_at(-5.0, speed=14.0), route=curved_route(), decision=bare))
    assert not steps_in(propose([corner], ego=ego_at(-5.0, speed=14.0), route=straight_route(), decision=bare))


def test_a_plan_that_already_stops_is_left_alone():
    scene = scene_of([Box(1, 25.0, 0.0)])
    assert not steps_in(propose([Box(1, 25.0, 0.0)], decision=keep_on(scene, speed=4.0)))


def test_a_blind_policy_stops_short_of_an_obstacle():
    for adaptive in (True, False):
        run = drive(GuardedRepairer(method(adaptive=adaptive)), [Box(1, 60.0, 0.0)], 14.0)
        assert min(run.gaps) > 0.0
        assert run.speeds[-1] < 1.0


def test_crossing_traffic_is_let_through_and_the_drive_goes_on():
    repairer = GuardedRepairer(method())
    for arrival in (2.6, 2.8, 3.0, 3.2, 3.4):
        run = drive(repairer, [crossing(arrival)], 10.0)
        assert min(run.gaps) > 0.0
        assert run.speeds[-1] == pytest.approx(10.0, abs=0.3)
        assert not any(run.interventions[round((arrival + 1.0) / TICK) :])


def test_adaptive_is_milder_than_the_full_brake():
    adaptive = drive(GuardedRepairer(method()), [crossing(3.0)], 10.0)
    simple = drive(GuardedRepairer(method(adaptive=False)), [crossing(3.0)], 10.0)
    assert min(simple.gaps) > 0.0
    assert adaptive.intensity < 0.7 * simple.intensity


def test_interventions_last_their_least_duration_and_do_not_flap():
    run = drive(GuardedRepairer(method()), [crossing(3.0), Box(2, 90.0, 0.0, speed=4.0)], 10.0)
    onsets = [index for index, pair in enumerate(pairwise(run.interventions)) if pair == (False, True)]
    assert len(onsets) <= 20
    assert all(later - earlier >= 0.3 / TICK for earlier, later in pairwise(onsets))


@pytest.mark.parametrize("y", [2.05, -2.05, 1.85])
def test_a_stopped_ego_drives_away_from_what_is_close_but_not_in_its_path(y):
    run = drive(GuardedRepairer(method()), [Box(1, 4.0, y)], 5.0, speed=0.0)
    assert run.positions[-1] > 18.0
    assert min(run.gaps) > 0.0


def test_a_stopped_ego_goes_on_as_soon_as_the_obstacle_is_gone():
    def leave(time, box):
        return box if time < 10.0 else Box(box.id, box.x, 50.0)

    run = drive(GuardedRepairer(method()), [Box(1, 40.0, 0.0)], 18.0, move=leave)
    assert run.speeds[round(9.9 / TICK)] < 0.5
    assert run.positions[-1] > 50.0
    assert not any(run.interventions[round(10.4 / TICK) :])


def test_the_hard_stop_takes_the_way_that_physics_says():
    run = drive(GuardedRepairer(method(adaptive=False)), [Box(1, 11.5, 0.0)], 3.0)
    begin = run.interventions.index(True)
    stopped = next(index for index, speed in enumerate(run.speeds) if index > begin and speed < 0.5)
    assert (stopped - begin) * TICK == pytest.approx(10.0 / FULL_BRAKE, abs=0.15)


def test_a_scene_without_objects_is_clear():
    proposal = propose([])
    assert (proposal.score, proposal.threshold) == (0.0, 0.0)
