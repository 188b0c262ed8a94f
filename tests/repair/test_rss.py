import math

import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.route import RightOfWay
from roadmend.core.scene import Signal
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.parameters import RssParameters
from roadmend.repair.rss import RssRepair, law_of
from roadmend.repair.rss_law import lateral, opposite_direction, same_direction, stopping_distance

from .playground import Box, curved_route, drive, ego_at, keep_on, scene_of, straight_route, two_lane_route

NORTH = 0.5 * math.pi
LAW = law_of(RssParameters())


def propose(boxes, *, ego=None, route=None, decision=None, signals=(), **parameters):
    made = RssRepair(RssParameters(**parameters))
    made.reset(route or straight_route())
    scene = scene_of(boxes, ego=ego, signals=signals)
    return made.propose(scene, decision or keep_on(scene))


def steps_in(proposal) -> bool:
    return proposal.score > proposal.threshold


def crossing(arrival: float, speed: float = 8.0, at: float = 12.0) -> Box:
    return Box(9, at, -speed * arrival, NORTH, speed)


def test_the_longitudinal_formula_by_hand():
    # 0.5 s from 10 to 11 m/s, then 121 / 10 m of braking; the one ahead stops within 64 / 16 m
    assert stopping_distance(10.0, LAW) == pytest.approx(5.25 + 12.1)
    assert same_direction(10.0, 8.0, LAW) == pytest.approx(5.25 + 12.1 - 4.0)
    assert same_direction(2.0, 30.0, LAW) == 0.0
    assert opposite_direction(10.0, 5.0, LAW) == pytest.approx(5.25 + 12.1 + 2.75 + 3.6)


def test_the_lateral_formula_by_hand():
    # own: 0.05 * 0.5 + 0.01 / 1.6; theirs: 1.05 * 0.5 + 1.21 / 1.6; and mu
    assert lateral(1.0, LAW) == pytest.approx(0.3 + 0.025 + 0.00625 + 0.525 + 0.75625)
    assert lateral(0.0, LAW) == 0.0
    assert lateral(-1.0, LAW) == 0.0


def test_a_safe_distance_is_safe_against_the_worst_that_the_one_ahead_can_do():
    for rear in (2.0, 8.0, 15.0, 25.0):
        for front in (0.0, 5.0, 15.0, 25.0):
            gap, own, other, time = same_direction(rear, front, LAW) + 1e-6, rear, front, 0.0
            while own > 0.0:
                own = max(0.0, own + 1e-3 * (LAW.accel if time < LAW.rho else -LAW.brake))
                other = max(0.0, other - 1e-3 * LAW.hardest)
                gap += 1e-3 * (other - own)
                time += 1e-3
                assert gap > -0.03


@pytest.mark.parametrize("front", [0.0, 5.0, 10.0])
@pytest.mark.parametrize("share", [0.0, 0.5, 0.99, 1.01, 2.0])
def test_it_responds_below_the_safe_distance_only(front, share):
    gap = share * same_direction(10.0, front, LAW)
    proposal = propose([Box(3, gap + 4.5, 0.0, speed=front)])
    assert steps_in(proposal) == (share < 1.0)
    assert proposal.score == pytest.approx(1.0 - share, abs=1e-6)
    if steps_in(proposal):
        assert proposal.action <= -5.0 / 8.0
        assert proposal.triggers[0].object_id == 3
        assert f"{gap:.1f} m" in proposal.reason


@pytest.mark.parametrize("y", [1.85, 2.5, 3.5, -3.5])
def test_who_stays_in_the_next_lane_is_no_concern(y):
    assert not steps_in(propose([Box(1, 6.0, y, speed=10.0)]))


def test_who_closes_in_sideways_is_a_concern_before_it_arrives():
    assert steps_in(propose([Box(1, 8.0, 2.8, -0.15, speed=8.0)]))


def test_oncoming_in_the_own_lane_needs_both_stopping_distances():
    safe = opposite_direction(10.0, 10.0, LAW)
    assert steps_in(propose([Box(1, safe + 4.0, 0.0, math.pi, 10.0)]))
    assert not steps_in(propose([Box(1, safe + 5.0, 0.0, math.pi, 10.0)], time_gap=0.0, horizon=1.0))
    assert not steps_in(propose([Box(1, 15.0, 3.5, math.pi, 10.0)]))


def test_who_is_behind_sees_to_itself():
    assert not steps_in(propose([Box(1, -6.0, 0.0, speed=25.0)]))


@pytest.mark.parametrize(("arrival", "meets"), [(0.0, False), (1.0, True), (1.5, True), (5.0, False)])
def test_crossing_traffic_counts_within_the_time_gap(arrival, meets):
    assert steps_in(propose([crossing(arrival, at=16.0)])) == meets


def test_while_it_can_still_stop_later_it_does_not_brake_yet():
    assert not steps_in(propose([crossing(4.0, at=40.0)]))


def test_inside_the_shared_ground_it_clears():
    assert not steps_in(propose([Box(9, 1.0, -8.0, NORTH, 8.0)]))


def test_too_late_to_stop_but_first_it_clears():
    assert not steps_in(propose([Box(9, 6.0, -8.0, NORTH, 8.0)]))


def test_too_late_to_stop_and_second_it_brakes_as_hard_as_it_can():
    proposal = propose([Box(9, 7.0, -2.0, NORTH, 2.0)])
    assert steps_in(proposal)
    assert proposal.action == -1.0


@pytest.mark.parametrize(
    ("rule", "signals", "trusts"),
    [
        (RightOfWay.PRIORITY, (), True),
        (RightOfWay.YIELD, (), False),
        (RightOfWay.STOP, (), False),
        (RightOfWay.SIGNAL, (Signal.GREEN,), True),
        (RightOfWay.SIGNAL, (Signal.RED,), False),
        (RightOfWay.SIGNAL, (Signal.YELLOW,), False),
        (RightOfWay.SIGNAL, (), False),
        (None, (), False),
    ],
)
def test_right_of_way_is_trusted_only_where_the_route_gives_it(rule, signals, trusts):
    route = straight_route(rule, signal=0)
    ego = ego_at(32.0)
    far = Box(9, 48.0, -22.0, NORTH, 9.0)
    assert steps_in(propose([far], ego=ego, route=route, signals=signals)) != trusts
    near = Box(9, 48.0, -12.0, NORTH, 9.0)  # cannot stop any more: right of way is given, not taken
    assert steps_in(propose([near], ego=ego, route=route, signals=signals))


def lane_change_plan(speed: float = 10.0) -> Decision:
    scene = scene_of([], ego=ego_at(speed=speed))
    plan = keep_on(scene).trajectory
    y = 3.2 * (plan.x / plan.x[-1])
    return Decision(Command(0.2, 0.0), Trajectory(0.1, plan.x, y, plan.yaw + 0.1, plan.speed))


def test_merging_behind_somebody_needs_the_safe_distance():
    near, far = Box(1, 5.5, 3.2, speed=6.0), Box(1, 26.0, 3.2, speed=10.0)
    assert steps_in(propose([near], route=two_lane_route(), decision=lane_change_plan()))
    assert not steps_in(propose([far], route=two_lane_route(), decision=lane_change_plan()))


def test_ahead_means_along_the_curved_path():
    bare = Decision(Command(0.2, 0.0), Trajectory.empty())
    corner = Box(1, 13.0, 5.5, 0.8)
    assert steps_in(propose([corner], ego=ego_at(-1.0), route=curved_route(), decision=bare))
    assert not steps_in(propose([Box(1, 16.0, -4.0)], ego=ego_at(-1.0), route=curved_route(), decision=bare))


def test_a_blind_policy_stops_short_of_an_obstacle():
    run = drive(GuardedRepairer(RssRepair()), [Box(1, 60.0, 0.0)], 12.0)
    assert min(run.gaps) > 0.0
    assert run.speeds[-1] < 0.5


def test_a_leader_that_brakes_as_hard_as_it_can_is_not_hit():
    run = drive(GuardedRepairer(RssRepair()), [Box(1, 25.0, 0.0, speed=10.0, acceleration=-8.0)], 8.0)
    assert min(run.gaps) > 0.0


def test_crossing_traffic_is_let_through_and_the_drive_goes_on():
    for arrival in (2.4, 2.8, 3.2, 3.6):
        run = drive(GuardedRepairer(RssRepair()), [crossing(arrival, at=30.0)], 12.0)
        assert min(run.gaps) > 0.0
        assert run.speeds[-1] == pytest.approx(10.0, abs=0.3)


@pytest.mark.parametrize("y", [1.85, 2.05, -2.05])
def test_a_stopped_ego_drives_away_from_what_is_close_but_not_in_its_path(y):
    run = drive(GuardedRepairer(RssRepair()), [Box(1, 4.0, y)], 5.0, speed=0.0)
    assert run.positions[-1] > 18.0


def test_a_stopped_ego_follows_a_leader_that_drives_off():
    def leave(time, box):
        return box if time < 10.0 else Box(box.id, box.x, box.y, speed=8.0)

    run = drive(GuardedRepairer(RssRepair()), [Box(1, 40.0, 0.0)], 18.0, move=leave)
    assert run.speeds[round(9.9 / 0.05)] < 0.5
    assert run.positions[-1] > 40.0
    assert min(run.gaps) > 0.0


def test_the_release_needs_more_room_than_the_onset():
    made = RssRepair()
    made.reset(straight_route())

    def score_at(time, gap):
        scene = scene_of([Box(1, gap + 4.5, 0.0)], time)
        return steps_in(made.propose(scene, keep_on(scene)))

    safe = same_direction(10.0, 0.0, LAW)
    assert not score_at(0.0, safe * 1.05)
    assert score_at(0.05, safe * 0.99)
    assert score_at(1.0, safe * 1.15)
    assert score_at(2.0, safe * 1.21)
    assert not score_at(2.15, safe * 1.21)
    assert not score_at(2.2, safe * 1.05)
