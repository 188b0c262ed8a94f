"""The guard over the whole grid of inputs: whatever comes, a command leaves that is valid and accelerates no more."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.repair import Proposal, RepairStatus, RepairTrigger
from roadmend.core.scene import OBJECT, EgoState, ObjectList, Scene
from roadmend.recording import messages
from roadmend.recording.codec import encode
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.sanitise import sanitise_command

from .playground import curved_route, straight_route

EXAMPLES = 200
QUIET = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[*HealthCheck], derandomize=True)

odd = st.sampled_from([math.nan, math.inf, -math.inf, -0.0, 1e-300, 1e300, -1e300, 2.0, -1.0])
pedals = st.one_of(st.floats(0.0, 1.0), odd, st.floats())
commands = st.builds(Command, pedals, pedals, st.booleans())
places = st.one_of(st.floats(-80.0, 80.0), odd, st.floats())
things = st.sampled_from([None, 3, "much", (3,), math.nan, 10**400])
triggers = st.builds(RepairTrigger, st.integers(0, 9) | st.integers() | things, st.floats(0.0, 1.0) | odd | things)
proposals = st.builds(
    Proposal,
    st.one_of(st.floats(0.0, 1.0), st.floats()),
    st.one_of(st.floats(0.0, 1.0), st.floats()),
    st.one_of(st.floats(-1.0, 1.0), odd, st.floats()),
    triggers=st.one_of(st.just(()), st.tuples(triggers), things),
    reason=st.one_of(st.just(""), st.sampled_from(["because", "\ud800"]), things),
    worth=st.one_of(st.none(), st.floats(-1.0, 1.0), odd, things),
    hold_back=st.booleans() | things,
)
answers = st.one_of(proposals, st.sampled_from([None, "brake", ValueError("out of tune"), ZeroDivisionError()]))


@st.composite
def object_lists(draw):
    """Lists with ids that come again, sizes that cannot be, and numbers that are none."""
    count = draw(st.integers(0, 12))
    table = np.zeros(count, dtype=OBJECT)
    for row in range(count):
        table[row]["id"] = draw(st.integers(0, 5) | st.integers(0, 2**32 - 1))
        table[row]["kind"] = draw(st.integers(0, 255))
        for name in ("x", "y", "yaw", "speed", "acceleration", "yaw_rate"):
            table[row][name] = draw(places)
        for name in ("length", "width"):
            table[row][name] = draw(st.floats(0.5, 12.0) | odd)
    return ObjectList(table)


@st.composite
def plans(draw):
    """Plans whose arrays may differ in length."""
    sizes = (
        [draw(st.integers(0, 4))] * 4
        if draw(st.booleans())
        else draw(st.lists(st.integers(0, 4), min_size=4, max_size=4))
    )
    arrays = [np.array([draw(places) for _ in range(size)], dtype=np.float64) for size in sizes]
    return Trajectory(draw(st.floats(0.05, 0.5) | odd), *arrays)


@st.composite
def scenes(draw):
    """What is seen at any moment, in any order of time."""
    values = [draw(places) for _ in range(4)]
    speed, rate, width = draw(st.floats(0.0, 20.0) | odd), draw(places), draw(st.just(1.8) | odd)
    ego = EgoState.from_quaternion(*values, speed, rate, 4.5, width)
    time = draw(st.integers(0, 100).map(lambda tick: 0.05 * tick) | odd)
    return Scene(
        time, ego, draw(object_lists()), np.array(draw(st.lists(st.integers(0, 255), max_size=3)), dtype=np.uint8)
    )


class Told:
    """A method that answers what it is told, if it answers at all."""

    name = "told"

    def __init__(self):
        self.answer = None

    def reset(self, route):
        pass

    def propose(self, scene, decision):
        assert not decision.command.fault  # what a method is shown has been checked
        assert np.isfinite(scene.objects.x).all()
        assert len(np.unique(scene.objects.id)) == len(scene.objects)
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def check(repair, command, stop, count):
    """What holds of every answer."""
    assert repair.command.fault == ""
    assert -1.0 <= repair.final_action <= 1.0
    asked = sanitise_command(command, stop)
    assert asked.fault == ""
    assert repair.final_action <= asked.action
    if not command.fault:
        assert asked == command
    if math.isfinite(command.throttle):
        assert repair.command.throttle <= max(0.0, command.throttle)
    if math.isfinite(command.brake) and command.brake >= 0.0:
        assert repair.command.brake >= min(1.0, command.brake)
    assert not repair.command.change_lane or command.change_lane
    assert not (repair.held_back and repair.command.change_lane)
    assert not repair.held_back or repair.intervened
    assert repair.status in set(RepairStatus)
    assert 0 <= repair.dropped_objects <= count
    assert "\n" not in repair.reason
    header = messages.header_at(0)
    assert encode(messages.command_message_of(repair.command, header))
    assert encode(messages.repair_message_of(repair, "told", header))


@QUIET
@given(st.lists(st.tuples(scenes(), commands, plans(), answers), min_size=1, max_size=4))
def test_over_the_whole_grid_a_valid_command_leaves_that_accelerates_no_more(ticks):
    method = Told()
    guard = GuardedRepairer(method)
    guard.reset(straight_route())
    for scene, command, plan, answer in ticks:
        method.answer = answer
        check(guard.step(scene, Decision(command, plan)), command, guard.stop_brake, len(scene.objects))


@QUIET
@given(
    st.one_of(st.none(), scenes()),
    st.one_of(st.none(), st.builds(Decision, commands, plans())),
    st.sampled_from([RepairStatus.STARTING, RepairStatus.STALE_COMMAND, RepairStatus.STALE_OBJECTS]),
)
def test_a_controlled_stop_brakes_whatever_is_left_of_a_tick(scene, decision, status):
    guard = GuardedRepairer(Told())
    guard.reset(curved_route())
    repair = guard.controlled_stop(status, "why", scene, decision)
    assert repair.command.fault == ""
    assert repair.command.throttle == 0.0
    assert repair.command.brake >= guard.stop_brake
    assert not repair.command.change_lane
    assert repair.status is status


@pytest.mark.parametrize("thing", [None, "decision", 3, Decision(None, None), Decision(Command("a", None), None)])
def test_what_is_no_decision_is_a_stop(thing):
    guard = GuardedRepairer(Told())
    guard.reset(straight_route())
    ego = EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.5, 1.8)
    repair = guard.step(Scene(0.0, ego, ObjectList.empty(), np.empty(0, np.uint8)), thing)
    assert repair.command.fault == ""
    assert repair.final_action < 0.0
