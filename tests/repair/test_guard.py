import itertools
import math

import numpy as np
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.repair import Proposal, RepairStatus
from roadmend.repair.guard import GRAVITY, GuardedRepairer, gravest
from roadmend.repair.none import NoRepair
from roadmend.repair.parameters import GuardParameters

from .playground import Box, ego_at, keep_on, scene_of, straight_route

QUIET = Proposal(0.0, 0.5, 0.8)


class Scripted:
    """A method that does what it is told and remembers what it was shown."""

    name = "scripted"

    def __init__(self, answer=QUIET):
        self.answer = answer
        self.resets = 0
        self.seen = []

    def reset(self, route):
        self.resets += 1

    def propose(self, scene, decision):
        self.seen.append((scene, decision))
        if callable(self.answer):
            return self.answer()
        return self.answer


def guarded(method=None, **parameters) -> GuardedRepairer:
    """A guard one tick into the episode, so that RESET is over."""
    repairer = GuardedRepairer(method or Scripted(), GuardParameters(**parameters))
    repairer.reset(straight_route())
    scene = scene_of([], -0.05)
    assert repairer.step(scene, keep_on(scene)).status in {RepairStatus.RESET, RepairStatus.MODEL_FAULT}
    return repairer


def step(repairer, boxes=(), time=0.0, command=None, trajectory=None, ego=None):
    scene = scene_of(boxes, time, ego)
    decision = keep_on(scene)
    return repairer.step(scene, Decision(command or decision.command, trajectory or decision.trajectory))


def fail():
    raise ValueError("out of tune")


def test_a_clean_tick_passes_the_very_command():
    command = Command(0.4, 0.0, change_lane=True)
    repair = step(guarded(), command=command)
    assert repair.command is command
    assert repair.status == RepairStatus.PASS
    assert not repair.intervened
    assert repair.reason == ""


def test_a_repair_is_reported():
    repair = step(guarded(Scripted(Proposal(0.9, 0.5, -0.6, reason="because"))), command=Command(0.4, 0.0, True))
    assert repair.status == RepairStatus.REPAIRED
    assert repair.intervened
    assert (repair.policy_action, repair.repair_action, repair.final_action) == (0.4, -0.6, -0.6)
    assert repair.command.change_lane
    assert repair.reason == "because"


def test_the_gravest_status_wins_whatever_the_order():
    assert set(GRAVITY) == set(RepairStatus)
    assert gravest() == RepairStatus.PASS
    for first in RepairStatus:
        for second in RepairStatus:
            assert gravest(first, second) == gravest(second, first)
            assert GRAVITY.index(gravest(first, second)) == max(GRAVITY.index(first), GRAVITY.index(second))


def test_before_a_route_the_vehicle_is_held():
    repairer = GuardedRepairer(NoRepair())
    repair = step(repairer)
    assert repair.status == RepairStatus.STARTING
    assert repair.final_action == -0.5


@pytest.mark.parametrize(
    "command", [Command(math.nan, 0.0), Command(2.0, 0.0), Command(0.5, 0.5), Command(-0.1, 0.0), Command(0.0, 1.1)]
)
def test_an_invalid_command_never_reaches_method_or_vehicle(command):
    method = Scripted()
    repair = step(guarded(method), command=command)
    assert repair.status == RepairStatus.INVALID_COMMAND
    assert repair.command.fault == ""
    assert repair.intervened
    assert method.seen[-1][1].command == repair.command
    assert "taken as" in repair.reason


def test_the_method_can_still_brake_harder_than_a_sanitised_command():
    repair = step(guarded(Scripted(Proposal(0.9, 0.5, -1.0))), command=Command(math.nan, 0.0))
    assert repair.status == RepairStatus.INVALID_COMMAND
    assert repair.final_action == -1.0


def test_an_unusable_plan_is_replaced_by_the_route():
    method = Scripted()
    bad = np.array([1.0, math.nan])
    command = Command(0.3, 0.0)
    repair = step(guarded(method), command=command, trajectory=Trajectory(0.1, bad, bad, bad, bad))
    assert repair.status == RepairStatus.INVALID_COMMAND
    assert repair.command is command
    assert not repair.intervened
    assert len(method.seen[-1][1].trajectory) == 0


def test_unusable_objects_are_dropped_one_by_one_and_counted():
    method = Scripted()
    boxes = [
        Box(1, 20.0, 9.0),
        Box(2, math.nan, 0.0),
        Box(1, 40.0, 9.0),
        Box(3, 50.0, 9.0, length=-4.0),
        Box(4, 60.0, 9.0),
    ]
    repair = step(guarded(method), boxes)
    assert repair.status == RepairStatus.INVALID_OBJECTS
    assert repair.dropped_objects == 3
    assert method.seen[-1][0].objects.id.tolist() == [1, 4]


def test_a_long_list_is_not_truncated():
    method = Scripted()
    boxes = [Box(index, 5.0 * index, 50.0) for index in range(300)]
    repair = step(guarded(method), boxes)
    assert repair.status == RepairStatus.PASS
    assert len(method.seen[-1][0].objects) == 300


@pytest.mark.parametrize("field", ["x", "speed", "yaw", "length"])
def test_unusable_odometry_stops_the_vehicle(field):
    repair = step(guarded(), ego=ego_at()._replace(**{field: math.nan}))
    assert repair.status == RepairStatus.STALE_OBJECTS
    assert repair.final_action == -0.5


def test_a_stamp_that_is_not_a_number_stops_the_vehicle():
    assert step(guarded(), time=math.nan).status == RepairStatus.STALE_OBJECTS


@pytest.mark.parametrize("decision", [None, Decision(None, Trajectory.empty()), Decision(Command(0.1, 0.0), None)])
def test_a_decision_of_the_wrong_shape_is_no_decision(decision):
    repair = guarded().step(scene_of([]), decision)
    assert repair.status == RepairStatus.STALE_COMMAND
    assert repair.final_action == -0.5


@pytest.mark.parametrize("time", [-0.05, -3.0, 5.0])
def test_time_that_repeats_runs_back_or_jumps_clears_the_memory(time):
    method = Scripted()
    repairer = guarded(method)
    repair = step(repairer, time=time)
    assert repair.status == RepairStatus.RESET
    assert method.resets == 2
    assert "time went" in repair.reason
    assert step(repairer, time=time + 0.05).status == RepairStatus.PASS


def test_the_tick_of_a_reset_is_still_repaired():
    repair = step(guarded(Scripted(Proposal(0.9, 0.5, -1.0))), time=-1.0)
    assert repair.status == RepairStatus.RESET
    assert repair.final_action == -1.0


@pytest.mark.parametrize(
    "answer",
    [
        fail,
        Proposal(math.nan, 0.5, -1.0),
        Proposal(0.9, math.nan, -1.0),
        Proposal(0.9, 0.5, math.nan),
        Proposal(0.9, 0.5, -1.5),
        Proposal(0.1, 0.5, 1.5),
        lambda: None,
    ],
)
def test_rss_decides_where_the_method_fails(answer):
    repair = step(guarded(Scripted(answer)), [Box(1, 8.0, 0.0)])
    assert repair.status == RepairStatus.MODEL_FAULT
    assert repair.final_action <= -0.6
    assert [trigger.object_id for trigger in repair.triggers] == [1]
    free = step(guarded(Scripted(answer)))
    assert free.status == RepairStatus.MODEL_FAULT
    assert not free.intervened


def test_a_method_that_cannot_be_reset_is_a_fault_until_it_can():
    method = Scripted()
    repairer = guarded(method)
    method.reset = lambda route: fail()
    repairer.reset(straight_route())
    for tick in range(3):
        repair = step(repairer, time=0.05 * tick)
        assert repair.status == RepairStatus.MODEL_FAULT
        assert "could not be reset" in repair.reason
    method.reset = lambda route: None
    repairer.reset(straight_route())
    step(repairer, time=1.0)
    assert step(repairer, time=1.05).status == RepairStatus.PASS


def test_when_even_rss_fails_the_vehicle_stops():
    repairer = guarded(Scripted(fail))
    repairer._rule = Scripted(fail)
    repair = step(repairer)
    assert repair.status == RepairStatus.MODEL_FAULT
    assert repair.final_action == -0.5
    repairer._rule = Scripted(Proposal(math.nan, 0.0, 0.0))
    assert step(repairer, time=0.05).final_action == -0.5


def test_an_overrun_of_the_budget_is_a_fault_and_off_by_default(monkeypatch):
    clock = itertools.count(0.0, 0.02)
    monkeypatch.setattr("roadmend.repair.guard.time.perf_counter", lambda: next(clock))
    assert step(guarded(budget=0.03)).status == RepairStatus.PASS
    late = step(guarded(Scripted(Proposal(0.9, 0.5, -1.0)), budget=0.01))
    assert late.status == RepairStatus.MODEL_FAULT
    assert late.final_action == 0.2
    assert "took 20.0 ms of 10.0 ms" in late.reason
    begun = next(clock)
    assert step(guarded()).status == RepairStatus.PASS
    assert next(clock) == pytest.approx(begun + 0.02)  # nobody looked


@pytest.mark.parametrize("status", [RepairStatus.STARTING, RepairStatus.STALE_COMMAND, RepairStatus.STALE_OBJECTS])
@pytest.mark.parametrize(("deceleration", "brake"), [(1.0, 0.125), (4.0, 0.5), (8.0, 1.0)])
def test_a_controlled_stop_is_bounded(status, deceleration, brake):
    repair = guarded(stop_deceleration=deceleration).controlled_stop(status, "0.31 s old")
    assert repair.status == status
    assert repair.command == Command(0.0, brake)
    assert math.isnan(repair.policy_action)
    assert repair.intervened
    assert "0.31 s old" in repair.reason


def test_a_controlled_stop_brakes_harder_where_policy_or_rss_ask_for_it():
    repairer = guarded()
    hard = repairer.controlled_stop(
        RepairStatus.STALE_OBJECTS, decision=Decision(Command(0.0, 0.9), Trajectory.empty())
    )
    assert hard.command.brake == 0.9
    near = repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([Box(1, 9.0, 0.0)]))
    assert near.command.brake > 0.9
    assert "rss" in near.reason
    broken = scene_of([Box(1, 9.0, 0.0)], ego=ego_at()._replace(x=math.nan))
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=broken).command.brake == 0.5
    repairer._rule = Scripted(fail)
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([])).command.brake == 0.5


def test_a_controlled_stop_takes_the_time_that_physics_says():
    speed, ticks = 12.0, 0
    repairer = guarded()
    while speed > 0.0:
        speed -= 0.05 * 8.0 * repairer.controlled_stop(RepairStatus.STALE_COMMAND).command.brake
        ticks += 1
    assert ticks * 0.05 == pytest.approx(3.0, abs=0.051)


def test_everything_wrong_at_once_reports_the_gravest():
    repair = step(guarded(Scripted(fail)), [Box(1, math.nan, 0.0)], time=-5.0, command=Command(1.0, 1.0))
    assert repair.status == RepairStatus.MODEL_FAULT
    assert repair.dropped_objects == 1
    assert repair.final_action == -1.0
    for part in ("dropped 1", "both pressed", "time went", "failed"):
        assert part in repair.reason


def test_arrays_that_cannot_be_written_to_are_fine():
    scene = scene_of([Box(1, 30.0, 0.0)])
    for name in ("id", "kind", "x", "y", "yaw", "speed", "acceleration", "yaw_rate", "length", "width"):
        getattr(scene.objects, name).flags.writeable = False
    assert guarded(NoRepair()).step(scene, keep_on(scene)).status == RepairStatus.PASS


def test_a_warm_up_leaves_no_trace():
    method = Scripted()
    repairer = GuardedRepairer(method)
    repairer.warm_up()
    assert len(method.seen) == 1
    assert step(repairer).status == RepairStatus.STARTING
    repairer.reset(straight_route())
    assert step(repairer).status == RepairStatus.RESET
    assert step(repairer, time=0.05).status == RepairStatus.PASS
