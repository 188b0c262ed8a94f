"""The privileged expert: drives like the modular policy, knows the road's friction, and advises other drivers."""

import pytest

from roadmend.core.route import RightOfWay
from roadmend.core.scene import Signal
from roadmend.policies.expert import Expert, action_for, expert_parameters

from .proving_ground import Body, drive, road, scene_at, two_lanes, zone


def test_drives_near_the_limit_when_the_road_is_free():
    run = drive(Expert(), road(), 15.0, 5.0, 0.0)
    assert run.speed[-1] == pytest.approx(13.9, abs=0.6)


def test_holds_for_red():
    run = drive(Expert(), road(zone(120.0, 140.0, RightOfWay.SIGNAL)), 20.0, 5.0, 12.0, signals=lambda _: (Signal.RED,))
    assert run.speed[-1] < 0.05
    assert run.x[-1] + 2.35 < 120.0


@pytest.mark.parametrize("friction", [0.35, 0.6, 0.9, 1.2])
def test_asks_for_no_more_than_the_road_transmits(friction):
    parameters = expert_parameters(friction)
    grip = 9.81 * friction
    assert parameters.hold_deceleration < grip
    assert parameters.deceleration < grip
    assert parameters.red_deceleration < grip


@pytest.mark.parametrize("friction", [0.06, 0.2])
def test_on_ice_it_keeps_to_the_ranges_of_the_parameters(friction):
    assert expert_parameters(friction).red_deceleration <= expert_parameters(0.35).red_deceleration


def test_begins_to_brake_earlier_where_it_knows_of_ice():
    def braking_begins(friction: float) -> float:
        expert = Expert()
        expert.privilege(friction)
        run = drive(
            expert, road(zone(200.0, 220.0, RightOfWay.SIGNAL)), 20.0, 5.0, 13.5, signals=lambda _: (Signal.RED,)
        )
        return next(x for x, decision in zip(run.x, run.decisions, strict=True) if decision.command.brake > 0.1)

    assert braking_begins(0.25) < braking_begins(0.9) - 5.0


def test_the_same_scene_gives_the_same_advice_whatever_it_advised_before():
    """Only what it has seen counts: an expert that watched the same drive in silence agrees."""
    body = Body(1, 90.0, 0.0, speed=4.0)
    first, second = Expert(), Expert()
    for expert in (first, second):
        expert.reset(road())
    for tick in range(40):
        first.step(scene_at(0.05 * tick, 30.0 + 0.5 * tick, 10.0, [body]))
        if tick % 2 == 0:
            second.step(scene_at(0.05 * tick, 30.0 + 0.5 * tick, 10.0, [body]))
    scene = scene_at(2.0, 50.0, 10.0, [body])
    assert first.step(scene).command.action == pytest.approx(second.step(scene).command.action, abs=1e-9)


def test_asks_again_for_a_lane_change_that_was_not_begun():
    expert = Expert()
    expert.reset(two_lanes())
    asked = []
    for tick in range(6):
        asked.append(expert.step(scene_at(0.05 * tick, 60.0 + 0.5 * tick, 10.0)).command.change_lane)
        expert.obeyed(change=False)
    assert all(asked)


def test_actions_stay_in_range():
    packed = expert_parameters(0.9).packed()
    for wanted in (-20.0, -3.0, 0.0, 1.0, 20.0):
        for speed in (0.0, 5.0, 40.0):
            assert -1.0 <= action_for(packed, wanted, speed) <= 1.0
