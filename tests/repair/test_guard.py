import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.repair import Proposal, RepairStatus, RepairTrigger
from roadmend.core.route import Stage
from roadmend.repair.guard import GRAVITY, GuardedRepairer, gravest
from roadmend.repair.none import NoRepair
from roadmend.repair.parameters import GuardParameters
from roadmend.repair.predictive import PredictiveRepair
from roadmend.repair.registry import make_repairer
from roadmend.repair.rss import RssRepair

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


@pytest.mark.parametrize(("asked", "hold_back"), [*itertools.product([False, True], repeat=2)])
def test_a_lane_change_that_is_held_back_is_reported_and_no_other(asked, hold_back):
    method = Scripted(Proposal(0.0, 0.5, 0.8, reason="somebody is there", hold_back=hold_back))
    repair = step(guarded(method), command=Command(0.4, 0.0, asked))
    assert repair.held_back is (asked and hold_back)
    assert repair.command.change_lane is (asked and not hold_back)
    assert repair.intervened is repair.held_back
    assert repair.status == (RepairStatus.REPAIRED if repair.held_back else RepairStatus.PASS)
    assert repair.final_action == 0.4


def test_no_lane_change_begins_that_no_method_judges():
    repair = step(guarded(Scripted(fail)), command=Command(0.4, 0.0, True))
    assert repair.status == RepairStatus.MODEL_FAULT
    assert repair.held_back is True
    assert not repair.command.change_lane
    assert step(guarded(Scripted(fail)), command=Command(0.4, 0.0)).held_back is False


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


@pytest.mark.parametrize("x", [[-50.0, -50.0, 100.0], [-50.0, math.nan, 100.0], [-50.0, 0.0, math.inf], [0.0, 0.0]])
@pytest.mark.parametrize("name", ["none", "rss", "predictive", "rule"])
def test_on_a_route_along_which_nobody_can_measure_the_vehicle_is_held(name, x):
    repairer = make_repairer(name)
    line = Stage(np.array(x), np.zeros(len(x)), np.full(len(x), 10.0))
    repairer.reset(replace(straight_route(), stages=(line,)))
    repair = step(repairer)
    assert repair.status == RepairStatus.STARTING
    assert repair.final_action == -0.5
    assert "unusable route: " in repair.reason
    repairer.reset(straight_route())
    assert step(repairer).status == RepairStatus.RESET


def test_what_is_no_route_at_all_holds_the_vehicle():
    repairer = guarded(Scripted())
    repairer.reset("the way home")
    assert step(repairer).final_action == -0.5


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


STANDS = Box(7, 14.0, 0.0)
WILD = Command(7.0, 0.0)


def test_a_command_that_cannot_be_is_judged_by_the_rule_as_well():
    method = Scripted(Proposal(0.1, 0.5, 0.8, hold_back=True))
    repairer = guarded(method)
    repair = step(repairer, [STANDS], command=WILD)
    assert repair.status == RepairStatus.INVALID_COMMAND
    assert repair.final_action < -0.3
    assert (repair.intervened, repair.score > repair.threshold) == (True, True)
    assert [trigger.object_id for trigger in repair.triggers] == [7]
    assert "; rss: " in repair.reason
    assert method.seen[-1][1].command == Command(1.0, 0.0)
    wish = step(repairer, [STANDS], time=0.05, command=replace(WILD, change_lane=True))
    assert not wish.command.change_lane
    later = step(repairer, [STANDS], time=0.95, command=WILD)  # what the rule remembers is long past by then
    assert later.final_action < -0.3
    assert "without rss" not in later.reason


def test_where_nobody_is_in_the_way_or_the_method_brakes_harder_its_word_stands():
    alone = step(guarded(), command=WILD)
    assert (alone.final_action, alone.score, "rss" in alone.reason) == (1.0, QUIET.score, False)
    harder = step(guarded(Scripted(Proposal(0.9, 0.5, -1.0, reason="mine"))), [STANDS], command=WILD)
    assert (harder.final_action, harder.reason.endswith("mine")) == (-1.0, True)


def test_a_valid_command_is_the_methods_affair_alone():
    assert step(guarded(), [STANDS], command=Command(1.0, 0.0)).final_action == 1.0
    plan = Trajectory(0.1, np.full(3, math.nan), *np.zeros((3, 3)))
    repair = step(guarded(), [STANDS], command=Command(1.0, 0.0), trajectory=plan)
    assert (repair.status, repair.final_action) == (RepairStatus.INVALID_COMMAND, 1.0)


@pytest.mark.parametrize("answer", [fail, lambda *_: Proposal(0.9, 0.5, -7.0)])
def test_where_the_rule_cannot_judge_it_either_the_methods_word_stands(answer):
    repairer = guarded(Scripted(Proposal(0.9, 0.5, -0.7)))
    repairer._rule.propose = lambda *_: answer()
    repair = step(repairer, [STANDS], command=WILD)
    assert (repair.status, repair.final_action) == (RepairStatus.INVALID_COMMAND, -0.7)
    assert ("without rss" in repair.reason) == (answer is fail)


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
    assert "unusable decision: " in repair.reason


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
        Proposal(0.1, 0.5, 0.8, triggers=(3,)),
        Proposal(0.1, 0.5, 0.8, triggers=(RepairTrigger(-1, 0.3),)),
        Proposal(0.1, 0.5, 0.8, worth="much"),
        Proposal(0.1, 0.5, 0.8, reason=None),
        Proposal(0.1, 0.5, 0.8, hold_back=np.ones(2)),
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


def test_numbers_of_other_libraries_become_plain_ones():
    told = [RepairTrigger(np.uint32(7), np.float32(0.5))]
    method = Scripted(
        Proposal(np.float32(0.75), np.float32(0.5), np.float32(-0.5), told, "because", np.float32(0.25), np.bool_(True))
    )
    repair = step(guarded(method), command=Command(0.4, 0.0, True))
    assert repair.held_back is True
    assert repair.triggers == (RepairTrigger(7, 0.5),)
    numbers = (repair.score, repair.threshold, repair.repair_action, repair.command.brake, repair.worth)
    assert numbers == (0.75, 0.5, -0.5, 0.5, 0.25)
    assert {type(number) for number in numbers} == {float}


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


def test_the_first_fault_of_a_method_is_kept_whatever_comes_later():
    method = Scripted()
    repairer = guarded(method)
    step(repairer)
    assert repairer.first_fault == ""
    method.answer = Proposal(0.9, 0.5, -1.5)
    spoilt = step(repairer, time=0.05)
    first = repairer.first_fault
    assert first.startswith(f"{method.name}: ")
    assert first in spoilt.reason
    method.answer = fail
    assert " failed: " in step(repairer, time=0.1).reason
    assert repairer.first_fault == first
    repairer.reset(straight_route())
    assert repairer.first_fault == first

    failing = guarded(Scripted(fail))
    reason = step(failing).reason
    assert failing.first_fault.startswith(f"{method.name} failed: ")
    assert failing.first_fault in reason

    method = Scripted()
    stuck = guarded(method)
    method.reset = lambda route: fail()
    stuck.reset(straight_route())
    assert stuck.first_fault == ""  # nobody has asked it yet
    step(stuck)
    assert "could not be reset" in stuck.first_fault


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
    slow = guarded(Scripted(Proposal(0.9, 0.5, -1.0)), budget=0.01)
    step(slow)
    assert slow.first_fault == ""  # it has answered
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


def let_pass(method, repairer, until, time=0.0):
    """Let the method answer every tick to ``until`` [s], with nobody around."""
    method.answer = QUIET
    while (time := time + 0.5) < until:
        step(repairer, time=time)
    return until


NEAR = [Box(7, 9.0, 0.0)]


@pytest.mark.parametrize("gap", [0.7, 60.0])
def test_what_the_rule_braked_for_at_one_fault_is_forgotten_at_a_later_one(gap):
    method = Scripted(fail)
    repairer = guarded(method)
    assert step(repairer, NEAR).final_action < -0.6
    later = let_pass(method, repairer, until=gap)
    method.answer = fail
    repair = step(repairer, time=later)
    assert repair.status == RepairStatus.MODEL_FAULT
    assert not repair.intervened
    assert repair.triggers == ()


@pytest.mark.parametrize("gap", [0.7, 60.0])
def test_nor_does_it_make_a_later_controlled_stop_harder(gap):
    method = Scripted()
    repairer = guarded(method)
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of(NEAR)).command.brake > 0.9
    later = let_pass(method, repairer, until=gap)
    stop = repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([], later))
    assert stop.command.brake == 0.5
    assert "rss" not in stop.reason


def test_a_stop_after_the_clock_was_set_back_knows_nothing_of_the_time_before():
    repairer = guarded()
    repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of(NEAR, 65.0))
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([], 5.0)).command.brake == 0.5


@pytest.mark.parametrize(("pause", "resets"), [(0.0, 0), (0.05, 0), (0.25, 0), (-0.05, 0), (0.35, 1), (-0.35, 1)])
def test_the_rule_keeps_its_memory_over_a_pause_as_short_as_its_hold(pause, resets):
    repairer = spied()
    for time in (1.0, 1.0 + pause):
        repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([], time))
    assert repairer._rule.resets == resets


def test_a_rule_that_cannot_forget_leaves_the_stop_that_is_bounded():
    repairer = spied(Proposal(0.9, 0.5, -1.0))
    repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([], 1.0))
    repairer._rule.reset = lambda route: fail()
    for time in (9.0, 9.05):
        stop = repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([], time))
        assert stop.command.brake == 0.5
        assert "without rss" in stop.reason


class Spy(Scripted):
    """Remembers the routes that it was reset to as well."""

    def __init__(self, answer=QUIET):
        super().__init__(answer)
        self.routes = []

    def reset(self, route):
        super().reset(route)
        self.routes.append(route)


def spied(answer=QUIET, method=None, **parameters):
    """A guard whose own rule is a spy, one tick into the episode."""
    repairer = guarded(method, **parameters)
    repairer._rule = Spy(answer)
    return repairer


def braking(brake):
    return Decision(Command(0.0, brake), Trajectory.empty())


@pytest.mark.parametrize(
    ("deceleration", "full", "brake"), [(4.0, 8.0, 0.5), (3.0, 12.0, 0.25), (4.0, 4.0, 1.0), (8.0, 2.0, 1.0)]
)
def test_the_brake_of_a_controlled_stop_is_its_share_of_the_full_deceleration(deceleration, full, brake):
    repairer = guarded(stop_deceleration=deceleration, full_brake=full)
    assert repairer.stop_brake == brake
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND).command == Command(0.0, brake)


@pytest.mark.parametrize("full", [6.0, 10.0])
def test_the_rule_brakes_with_its_share_of_the_full_deceleration_too(full):
    near = step(guarded(Scripted(fail), full_brake=full), [Box(1, 15.0, 0.0)])
    assert near.status == RepairStatus.MODEL_FAULT
    assert near.final_action * full == pytest.approx(-5.0)


@pytest.mark.parametrize(("interval", "count"), [(0.004, 1250), (1e-20, 30)])
@pytest.mark.parametrize("method", [RssRepair(), PredictiveRepair()])
def test_a_plan_that_cannot_be_followed_to_its_end_hides_nobody(method, interval, count):
    ego = ego_at(speed=30.0)
    way, none = 30.0 * interval * np.arange(1, count + 1), np.zeros(count)
    plan = Trajectory(interval, way, none, none, np.full(count, 30.0))
    repair = step(guarded(method), [Box(1, 70.0, 0.0)], command=Command(0.4, 0.0), trajectory=plan, ego=ego)
    assert repair.status == RepairStatus.INVALID_COMMAND
    assert "the planned trajectory is unusable: the route is used instead" in repair.reason
    assert repair.final_action < 0.0


def test_without_parameters_the_defaults_hold_and_the_name_is_the_methods():
    repairer = GuardedRepairer(Scripted())
    assert repairer.parameters == GuardParameters()
    assert repairer.name == "scripted"


def test_both_are_told_the_route():
    repairer = GuardedRepairer(Spy())
    repairer._rule = Spy()
    route = straight_route()
    repairer.reset(route)
    assert repairer._method.routes == repairer._rule.routes == [route]


@pytest.mark.parametrize("count", [63, 64, 65, 200])
def test_objects_are_dropped_from_lists_of_any_length(count):
    method = Scripted()
    boxes = [Box(index, 5.0 * index, 50.0) for index in range(count - 1)]
    repair = step(guarded(method), [*boxes, Box(0, 1.0, 50.0)])
    assert repair.dropped_objects == 1
    assert len(method.seen[-1][0].objects) == count - 1


@pytest.mark.parametrize(
    ("bound", "box"),
    [
        ({"max_length": 5.0}, Box(1, 50.0, 9.0, length=5.5)),
        ({"max_width": 3.0}, Box(1, 50.0, 9.0, width=3.5)),
        ({"max_speed": 30.0}, Box(1, 50.0, 9.0, speed=35.0)),
    ],
)
def test_what_an_object_may_measure_is_a_parameter(bound, box):
    assert step(guarded(), [box]).dropped_objects == 0
    assert step(guarded(**bound), [box]).dropped_objects == 1


def test_nothing_is_copied_where_nothing_is_wrong():
    method = Scripted()
    repairer = guarded(method)
    scene = scene_of([Box(1, 50.0, 9.0)])
    decision = keep_on(scene)
    repairer.step(scene, decision)
    assert method.seen[-1] == (scene, decision)
    assert method.seen[-1][0] is scene
    assert method.seen[-1][1] is decision


def test_an_invalid_command_costs_the_plan_nothing_and_an_unusable_plan_not_the_command():
    method = Scripted()
    repairer = guarded(method)
    scene = scene_of([])
    plan = keep_on(scene).trajectory
    repairer.step(scene, Decision(Command(2.0, 0.0), plan))
    assert method.seen[-1][1].trajectory is plan
    assert method.seen[-1][1].command == Command(1.0, 0.0)
    bad = np.array([math.nan])
    both = step(repairer, time=0.05, command=Command(2.0, 0.0), trajectory=Trajectory(0.1, bad, bad, bad, bad))
    assert both.status == RepairStatus.INVALID_COMMAND
    assert "taken as +1.00" in both.reason
    assert "route is used" in both.reason
    assert len(method.seen[-1][1].trajectory) == 0


def test_the_account_holds_what_the_method_said():
    trigger = RepairTrigger(7, 0.4)
    repair = step(guarded(Scripted(Proposal(0.9, 0.5, -0.6, (trigger,), "because", 0.3))), [Box(1, math.nan, 0.0)])
    assert repair.worth == 0.3
    assert (repair.score, repair.threshold, repair.triggers) == (0.9, 0.5, (trigger,))
    assert repair.dropped_objects == 1
    assert repair.status == RepairStatus.INVALID_OBJECTS
    assert repair.final_action == -0.6
    assert "dropped 1 unusable of 1 objects" in repair.reason
    assert repair.reason.endswith("; because")


@pytest.mark.parametrize(
    ("pause", "status"),
    [
        (0.001, RepairStatus.PASS),
        (0.5, RepairStatus.PASS),
        (0.51, RepairStatus.RESET),
        (0.0, RepairStatus.RESET),
        (-0.001, RepairStatus.RESET),
    ],
)
def test_a_pause_up_to_the_clock_jump_is_none(pause, status):
    repairer = guarded(clock_jump=0.5)
    step(repairer, time=1.0)
    step(repairer, time=2.0)
    assert step(repairer, time=2.0 + pause).status == status


def test_time_is_measured_from_tick_to_tick():
    repairer = guarded()
    assert {step(repairer, time=0.9 * tick).status for tick in range(5)} == {RepairStatus.PASS}


def test_a_new_episode_begins_with_a_reset_even_where_its_time_goes_on():
    method = Scripted()
    repairer = guarded(method)
    step(repairer, time=0.0)
    repairer.reset(straight_route())
    repair = step(repairer, time=0.05)
    assert repair.status == RepairStatus.RESET
    assert repair.reason == ""
    assert method.resets == 2


def test_the_first_tick_tells_the_graver_of_a_reset_and_of_what_is_dropped():
    repairer = GuardedRepairer(Scripted())
    repairer.reset(straight_route())
    assert step(repairer, [Box(1, math.nan, 0.0)]).status == RepairStatus.INVALID_OBJECTS


def test_a_rule_that_cannot_be_reset_is_a_fault_too_and_both_are_told():
    repairer = guarded()
    repairer._rule.reset = lambda route: fail()
    repairer.reset(straight_route())
    repair = step(repairer)
    assert repair.status == RepairStatus.MODEL_FAULT
    assert "rss could not be reset" in repair.reason
    repairer._method.reset = lambda route: fail()
    repairer.reset(straight_route())
    repair = step(repairer, time=0.05)
    assert "scripted could not be reset" in repair.reason
    assert "rss could not be reset" in repair.reason


def test_time_that_runs_back_takes_the_rules_memory_as_well():
    repairer = spied()
    step(repairer, time=-7.0)
    assert repairer._rule.resets == 1


def test_the_rule_is_shown_what_the_method_was_and_is_answered_for():
    trigger = RepairTrigger(3, 0.2)
    repairer = spied(Proposal(0.2, 0.1, -0.7, (trigger,), "near"), Scripted(fail))
    scene = scene_of([Box(1, math.nan, 0.0), Box(2, 50.0, 9.0)])
    repair = repairer.step(scene, Decision(Command(0.3, 0.0), Trajectory.empty()))
    ((seen, decision),) = repairer._rule.seen
    assert seen.objects.id.tolist() == [2]
    assert decision.command == Command(0.3, 0.0)
    assert (repair.score, repair.threshold, repair.triggers) == (0.2, 0.1, (trigger,))
    assert (repair.policy_action, repair.repair_action, repair.final_action) == (0.3, -0.7, -0.7)
    assert repair.dropped_objects == 1
    assert "out of tune" in repair.reason
    assert repair.reason.endswith("near")


def test_where_method_and_rule_fail_the_stop_is_no_softer_than_what_was_asked():
    for answer in (fail, Proposal(math.nan, 0.0, 0.0)):
        repairer = spied(answer, Scripted(fail))
        scene = scene_of([Box(1, math.nan, 0.0)])
        repair = repairer.step(scene, braking(0.9))
        assert repair.status == RepairStatus.MODEL_FAULT
        assert repair.command == Command(0.0, 0.9)
        assert repair.dropped_objects == 1
        assert len(repairer._rule.seen) == 1
        assert "dropped 1" in repair.reason
        assert "scripted failed" in repair.reason
        assert repair.reason.count("out of tune") == (2 if answer is fail else 1)
        assert repair.reason.endswith("; ValueError('out of tune')") is (answer is fail)


def test_neither_a_missing_route_nor_blind_odometry_softens_the_brake_that_was_asked_for():
    starting = GuardedRepairer(NoRepair()).step(scene_of([]), braking(0.9))
    assert (starting.status, starting.command.brake) == (RepairStatus.STARTING, 0.9)
    blind = guarded().step(scene_of([], ego=ego_at()._replace(x=math.nan)), braking(0.9))
    assert (blind.status, blind.command.brake) == (RepairStatus.STALE_OBJECTS, 0.9)
    assert starting.reason.endswith("no route yet")
    assert blind.reason.endswith("odometry is not finite")


def test_a_stop_tells_where_it_had_to_do_without_the_rule():
    repairer = spied(fail)
    stop = repairer.controlled_stop(RepairStatus.STALE_COMMAND, "late", scene_of([]))
    assert stop.command.brake == 0.5
    assert stop.reason.endswith("late; without rss: ValueError('out of tune')")


def test_without_a_decision_the_scene_still_counts():
    repair = guarded().step(scene_of([Box(1, 9.0, 0.0)]), None)
    assert repair.status == RepairStatus.STALE_COMMAND
    assert repair.command.brake > 0.9


@pytest.mark.parametrize("scene", [None, 7])
def test_what_is_no_scene_stops_the_vehicle(scene):
    repair = guarded().step(scene, braking(0.9))
    assert repair.status == RepairStatus.STALE_OBJECTS
    assert repair.command == Command(0.0, 0.5)
    assert "unusable input" in repair.reason


@pytest.mark.parametrize(
    ("asked", "brake", "intervened"),
    [
        (Command(0.4, 0.0, change_lane=True), 0.5, True),
        (Command(0.0, 0.2), 0.5, True),
        (Command(0.0, 0.5), 0.5, False),
        (Command(0.0, 0.9), 0.9, False),
    ],
)
def test_a_controlled_stop_tells_what_was_asked(asked, brake, intervened):
    decision = Decision(asked, Trajectory.empty())
    repair = guarded().controlled_stop(RepairStatus.STALE_OBJECTS, "blind", decision=decision)
    assert repair.command == Command(0.0, brake)
    assert (repair.policy_action, repair.repair_action, repair.intervened) == (asked.action, -brake, intervened)
    assert math.isnan(repair.score)
    assert math.isnan(repair.threshold)
    assert (repair.dropped_objects, repair.triggers) == (0, ())
    assert "blind" in repair.reason


def test_a_controlled_stop_takes_an_invalid_command_for_none():
    decision = Decision(Command(math.nan, 0.0), Trajectory.empty())
    repair = guarded().controlled_stop(RepairStatus.STALE_OBJECTS, decision=decision)
    assert (repair.policy_action, repair.final_action) == (-0.5, -0.5)
    broken = guarded().controlled_stop(RepairStatus.STALE_OBJECTS, decision=Decision(None, None))
    assert broken.final_action == -0.5
    assert math.isnan(broken.policy_action)


@pytest.mark.parametrize(
    ("wanted", "brake"), [(-0.95, 0.95), (-1.0, 1.0), (-0.9, 0.9), (-0.7, 0.9), (0.8, 0.9), (-1.5, 0.9)]
)
def test_in_a_controlled_stop_the_rule_may_only_brake_harder(wanted, brake):
    trigger = RepairTrigger(3, 0.2)
    repairer = spied(Proposal(0.2, 0.1, wanted, (trigger,), "near"))
    scene = scene_of([Box(1, math.nan, 0.0), Box(2, 50.0, 9.0)])
    repair = repairer.controlled_stop(RepairStatus.STALE_COMMAND, "late", scene, braking(0.9))
    ((seen, decision),) = repairer._rule.seen
    assert seen.objects.id.tolist() == [2]
    assert decision.command == Command(0.0, 0.9)
    assert len(decision.trajectory) == 0
    assert repair.command == Command(0.0, brake)
    assert (repair.policy_action, repair.repair_action) == (-0.9, -brake)
    if brake > 0.9:
        assert (repair.score, repair.threshold, repair.triggers) == (0.2, 0.1, (trigger,))
        assert "late; rss: near" in repair.reason
    else:
        assert math.isnan(repair.score)
        assert repair.triggers == ()
        assert "near" not in repair.reason


def test_a_controlled_stop_asks_the_rule_only_where_there_are_route_and_odometry():
    repairer = GuardedRepairer(Scripted())
    repairer._rule = Spy(Proposal(0.9, 0.5, -1.0))
    assert repairer.controlled_stop(RepairStatus.STARTING, scene=scene_of([])).final_action == -0.5
    repairer.reset(straight_route())
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND).final_action == -0.5
    blind = scene_of([], ego=ego_at()._replace(x=math.nan))
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=blind).final_action == -0.5
    assert repairer._rule.seen == []
    assert repairer.controlled_stop(RepairStatus.STALE_COMMAND, scene=scene_of([])).final_action == -1.0


@pytest.mark.parametrize(("budget", "status"), [(2.0, RepairStatus.PASS), (0.99, RepairStatus.MODEL_FAULT)])
def test_the_budget_is_not_overrun_by_what_uses_it_up(monkeypatch, budget, status):
    clock = itertools.count(100, 2)
    repairer = guarded(budget=budget if status == RepairStatus.PASS else 10.0)
    repairer.parameters = GuardParameters(budget=budget)
    monkeypatch.setattr("roadmend.repair.guard.time.perf_counter", lambda: next(clock))
    repair = step(repairer)
    assert repair.status == status
    assert ("took 2000.0 ms of 990.0 ms" in repair.reason) is (status == RepairStatus.MODEL_FAULT)


def test_a_warm_up_calls_everything_once_on_an_ordinary_scene():
    method = Spy()
    repairer = GuardedRepairer(method)
    repairer._rule = rule = Spy()
    repairer.warm_up()
    ((scene, decision),) = method.seen
    assert len(rule.seen) == 1
    assert method.routes == rule.routes
    (route,) = method.routes
    assert route.stages[0].length > scene.objects.x[0] > scene.ego.x > 0.0
    assert scene.ego.y == scene.objects.y[0] == scene.ego.yaw == 0.0
    assert scene.ego.speed > 0.0
    assert decision.command.fault == ""
    assert scene.signals.shape == (0,)
