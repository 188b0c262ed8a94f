import math

import numpy as np
import pytest

from roadmend.core.command import Command, Trajectory
from roadmend.core.repair import RepairStatus
from roadmend.core.route import Route, Stage
from roadmend.core.scene import ObjectList
from roadmend.recording import messages
from roadmend.recording.codec import encode
from roadmend.recording.foreign_commands import PEDALS, AccelerationForm, PedalForm
from roadmend.recording.foreign_objects import Detections, EgoOutline, OwnObjects
from roadmend.recording.foreign_repair import ForeignRepair
from roadmend.repair.assumed_motion import Assumption
from roadmend.repair.registry import make_repairer

from .foreign_messages import acceleration, detection, detections, header, odometry

PATIENCE = 0.3
NOT_TOLD = str(Assumption.PRESENT_TURN)


class Stack:
    """Another stack: an ego at 10 m/s along x, one who stands, and a controller that accelerates."""

    def __init__(self, method="rss", form=AccelerationForm, reader=Detections, stands_at=300.0):
        self.repair = ForeignRepair(EgoOutline(4.5, 1.8), reader(), form(PEDALS), PATIENCE)
        if method:
            self.repair.use(make_repairer(method))
        self.stands_at = stands_at

    def ego(self, time, **changes):
        self.repair.take_ego(odometry(time, **{"x": 10.0 * time} | changes), time)

    def objects(self, time, stamp=None, frame="odom"):
        stamp = time if stamp is None else stamp
        self.repair.take_objects(detections(stamp, detection("7", self.stands_at, 0.0), frame=frame), time)

    def command(self, time, wanted=1.0, stamp=None):
        return self.repair.take_command(acceleration(time if stamp is None else stamp, wanted), time)

    def drive(self, until=1.0, begin=0.0, silent=(), **what):
        """Ego at 50 Hz, objects at 10 Hz, commands at 20 Hz; returns the last answer."""
        answer = None
        for step in range(round(begin * 100), round(until * 100)):
            time = 0.01 * step
            if step % 2 == 0 and "ego" not in silent:
                self.ego(time)
            if step % 10 == 0 and "objects" not in silent:
                self.objects(time)
            if step % 5 == 0 and "command" not in silent:
                answer = self.command(time, **what)
        return answer


def test_nobody_in_the_way_lets_the_very_command_pass():
    stack = Stack()
    stack.drive()
    asked = acceleration(1.0, 0.7, 0.2)
    answer = stack.repair.take_command(asked, 1.0)
    assert answer.message is asked
    assert (answer.repair.status, answer.repair.reason) == (RepairStatus.PASS, NOT_TOLD)


@pytest.mark.parametrize("method", ["rss", "predictive", "rule"])
def test_who_stands_ahead_is_braked_for_and_named(method):
    answer = Stack(method, stands_at=24.0).drive()
    assert answer.repair.status is RepairStatus.REPAIRED
    assert [trigger.object_id for trigger in answer.repair.triggers] == [7]
    assert answer.message.accel.linear.x < -1.0
    assert answer.repair.reason.endswith(NOT_TOLD)


def test_before_everything_is_there_the_vehicle_is_held():
    stack = Stack()
    answer = stack.command(0.0)
    assert answer.repair.status is RepairStatus.STARTING
    assert answer.message.accel.linear.x == -4.0
    assert "no ego: none yet" in answer.repair.reason
    assert "no objects: none yet" in answer.repair.reason


@pytest.mark.parametrize("method", ["rss", "predictive", "rule", "adreft"])
def test_lists_that_come_a_little_late_hide_nobody(method):
    answers = []
    for late in (0.0, 0.12):  # [s] every second list: before the one before it by its stamp
        stack = Stack(method, stands_at=40.0)
        for step in range(60):
            time = 0.05 * step
            stack.ego(time)
            if step % 2 == 0:
                stack.objects(time, time - (late if step % 4 == 2 and step > 2 else 0.0))
            answers.append(stack.command(time).repair)
    usual, jittered = answers[:60], answers[60:]
    assert [one.status for one in jittered] == [one.status for one in usual]
    assert [one.final_action for one in jittered] == pytest.approx([one.final_action for one in usual])
    assert usual[-1].status is RepairStatus.REPAIRED


@pytest.mark.parametrize("part", ["ego", "objects"])
def test_an_input_that_ends_stops_the_vehicle_until_it_is_back(part):
    stack = Stack()
    stack.drive(1.0)
    assert stack.drive(1.15, 1.0, silent=(part,)).repair.status is RepairStatus.PASS  # not late yet
    answer = stack.drive(2.0, 1.15, silent=(part,))
    assert answer.repair.status is RepairStatus.STALE_OBJECTS
    assert f"no {part}: the last" in answer.repair.reason
    assert answer.message.accel.linear.x <= -4.0
    assert stack.repair.silent(1.99).keys() == {part}
    assert stack.drive(2.5, 2.0).repair.status is RepairStatus.PASS
    assert stack.repair.silent(2.49) == {}


def test_a_harder_brake_that_was_asked_for_stays():
    stack = Stack()
    assert stack.command(0.0, wanted=-7.0).message.accel.linear.x == -7.0


def test_a_command_that_ends_stops_the_vehicle():
    stack = Stack()
    stack.drive(1.0)
    assert stack.repair.overdue(1.2) is None
    stack.drive(1.5, 1.0, silent=("command",))
    answer = stack.repair.overdue(1.49)
    assert answer.repair.status is RepairStatus.STALE_COMMAND
    assert answer.repair.reason.startswith("controlled stop at brake 0.50: no command for 0.54 s")
    assert answer.message.accel.linear.x == -4.0


def stamp_of(message):
    return 1e-9 * messages.stamp_of(message.header)


@pytest.mark.parametrize("wanted", [0.7, -4.0])  # the latter is the brake of the stop: it would pass as it came
def test_a_stop_in_place_of_a_late_command_is_as_old_as_it_says(wanted):
    stack = Stack()
    stack.drive(1.0)
    asked = acceleration(0.97, wanted, 0.2)  # 0.03 s old when it arrives
    stack.repair.take_command(asked, 1.0)
    for late in (0.35, 0.4, 3.0):
        stop = stack.repair.overdue(1.0 + late)
        assert stop.message.accel.linear.x == -4.0
        assert stop.message.accel.linear.y == 0.2
        assert stamp_of(stop.message) == pytest.approx(0.97 + late)
        assert stop.message.header.frame_id == "base_link"
        assert 1e-9 * stop.stamp == pytest.approx(0.97 + late)
    assert stamp_of(asked) == pytest.approx(0.97)  # messages are values


def test_where_the_stacks_own_clock_stands_still_so_does_the_stop():
    stack = Stack()
    stack.drive(1.0)
    for late, clock, told in ((0.5, 1.2, 1.2), (60.0, 1.2, 1.2), (60.5, 0.2, 0.95), (61.0, 1.3, 1.3)):
        stop = stack.repair.overdue(1.0 + late, round(clock * 1e9))
        assert stamp_of(stop.message) == pytest.approx(told)


def test_where_commands_have_no_stamp_the_stop_has_none():
    stack = Stack()
    stack.repair.take_command(acceleration(0.0, 0.7), 1.0)
    assert stamp_of(stack.repair.overdue(1.5).message) == 0.0


def test_a_stamp_at_the_end_of_time_ends_nothing():
    stack = Stack()
    stack.repair.take_command(acceleration((1 << 31) - 0.5, 0.7), 1.0)
    assert encode(stack.repair.overdue(9.0).message)


@pytest.mark.parametrize("late", [0.1, 9.0])
def test_nor_does_the_state_that_goes_with_it(late):
    stack = Stack()
    last = messages.LATEST * 1e-9
    stack.drive(1.0)
    for answer in (stack.command(1.0, stamp=last), stack.command(1.1, stamp=last), stack.repair.overdue(1.5 + late)):
        assert encode(messages.repair_message_of(answer.repair, "rss", messages.header_at(answer.stamp)))


def test_so_is_one_in_place_of_our_own_command():
    stack = Stack(form=PedalForm)
    asked = messages.command_message_of(Command(0.4, 0.0), header(5.0))
    stack.repair.take_command(asked, 1.0)
    assert stamp_of(stack.repair.overdue(1.5).message) == pytest.approx(5.5)


def test_time_goes_on_for_the_rule_while_commands_are_missing():
    stack = Stack(stands_at=24.0)
    stack.drive(1.0)
    stack.drive(1.3, 1.0, silent=("command",))
    assert stack.repair.overdue(1.29).repair.triggers  # somebody is near
    braking = []
    for step in range(20):
        time = 1.3 + 0.05 * step
        stack.ego(time)
        stack.repair.take_objects(detections(time), time)  # and now nobody
        braking.append(bool(stack.repair.overdue(time).repair.triggers))
    assert braking[0]  # held for a while
    assert not braking[-1]


def test_a_command_that_comes_after_all_is_answered_as_ever_though_stops_were_stamped_later():
    stack = Stack()
    stack.drive(1.0)
    stack.drive(1.5, 1.0, silent=("command",))
    assert stack.repair.overdue(1.49) is not None
    asked = acceleration(1.3, 0.7)
    answer = stack.repair.take_command(asked, 1.5)
    assert answer.message is asked
    assert answer.repair.status is RepairStatus.PASS


def test_a_stop_for_a_command_from_before_the_repairer_is_stamped_like_any_other():
    stack = Stack(method="")
    stack.command(1.0)
    stack.repair.use(make_repairer("rss"))
    assert stamp_of(stack.repair.overdue(1.5).message) == pytest.approx(1.5)


def test_where_all_ends_the_stop_says_so():
    stack = Stack()
    stack.drive(1.0)
    answer = stack.repair.overdue(5.0)
    assert answer.repair.status is RepairStatus.STALE_OBJECTS
    assert "no command for 4.05 s; no ego: the last 4.02 s ago; no objects" in answer.repair.reason


def test_nothing_is_sent_before_the_first_command():
    stack = Stack()
    stack.drive(1.0, silent=("command",))
    assert stack.repair.overdue(9.0) is None
    assert stack.repair.silent(1.0).keys() == {"command"}


def test_nor_without_a_repairer():
    stack = Stack(method="")
    assert stack.drive() is None
    assert stack.repair.overdue(9.0) is None


@pytest.mark.parametrize(("age", "said"), [(0.5, "objects stamped 0.5"), (-0.5, "ego stamped 0.5")])
def test_what_arrives_in_time_but_is_old_is_late_all_the_same(age, said):
    stack = Stack()
    for step in range(10):
        stack.ego(0.1 * step)
        stack.objects(0.1 * step, stamp=max(0.001, 0.1 * step + 1.0 - age) if age < 0 else 0.1 * step + 1.0 - age)
        stack.repair.take_ego(odometry(0.1 * step + 1.0), 0.1 * step)
        answer = stack.command(0.1 * step)
    assert answer.repair.status in (RepairStatus.STARTING, RepairStatus.STALE_OBJECTS)
    assert said in answer.repair.reason
    assert said in stack.repair.silent(0.9)["objects"]


def test_objects_in_another_frame_are_as_good_as_none_and_the_reason_names_it():
    stack = Stack()
    for step in range(10):
        stack.ego(0.1 * step)
        stack.objects(0.1 * step, frame="camera")
        answer = stack.command(0.1 * step)
    assert answer.repair.status is RepairStatus.STARTING
    assert "frame 'camera'" in answer.repair.reason
    assert "frame 'camera'" in stack.repair.silent(0.9)["objects"]


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_command_that_is_no_number_brakes(bad):
    stack = Stack()
    stack.drive(1.0)
    answer = stack.command(1.0, wanted=bad)
    assert answer.repair.status is RepairStatus.INVALID_COMMAND
    assert answer.message.accel.linear.x == -4.0


def test_an_ego_that_is_not_finite_brakes():
    stack = Stack()
    stack.drive(1.0)
    stack.ego(1.0, x=math.nan)
    answer = stack.command(1.0)
    assert answer.repair.status is RepairStatus.STALE_OBJECTS
    assert answer.message.accel.linear.x == -4.0


def test_commands_with_a_zero_stamp_or_the_same_one_do_not_clear_the_memory():
    for stamp in (0.0, 123.0):
        stack = Stack()
        stack.ego(1.0)
        stack.objects(0.9)
        stack.objects(1.0)
        states = [stack.command(1.0 + 0.01 * step, stamp=stamp).repair.status for step in range(5)]
        assert states == [RepairStatus.RESET, *[RepairStatus.PASS] * 4]


@pytest.mark.parametrize("is_stamped", [True, False])
def test_an_intervention_ends_in_a_stack_without_stamps_too(is_stamped):
    stack = Stack(reader=OwnObjects)
    braked = []
    for step in range(200):
        time, stamp = 0.05 * step, 1.0 + 0.05 * step if is_stamped else 0.0
        stack.repair.take_ego(odometry(stamp, x=0.0, speed=8.0), time)
        ahead = 10.0 if 20 <= step < 30 else 1e4
        objects = ObjectList.of(
            id=[7], kind=1, x=[ahead], y=0.0, yaw=0.0, speed=0.0, acceleration=0.0, yaw_rate=0.0, length=4.5, width=1.8
        )
        told = header(stamp)
        told.frame_id = "odom"
        message = messages.object_message_of(objects, np.empty(0, dtype=np.uint8), told)
        stack.repair.take_objects(message, time)
        answer = stack.command(time, 0.3, stamp=stamp)
        braked += [step] if answer.repair.status is RepairStatus.REPAIRED else []
    assert braked[0] == 20
    assert len(braked) < 25


def test_a_clock_that_is_set_back_clears_it():
    stack = Stack()
    stack.drive(1.0)
    assert stack.command(1.0, stamp=50.0).repair.status is RepairStatus.RESET


def test_a_new_repairer_takes_over():
    stack = Stack("rss", stands_at=24.0)
    assert stack.drive(1.0).repair.intervened
    stack.repair.use(make_repairer("none"))
    assert not stack.drive(2.0, 1.0).repair.intervened


def route_to_the_left():
    """20 m along x, then a quarter circle of 15 m to the left, then north."""
    angle = np.linspace(0.0, 0.5 * math.pi, 20)[1:]
    x = np.concatenate([np.arange(-50.0, 21.0, 2.0), 20.0 + 15.0 * np.sin(angle), np.full(30, 35.0)])
    y = np.concatenate([np.zeros(36), 15.0 * (1.0 - np.cos(angle)), 15.0 + np.arange(2.0, 61.0, 2.0)])
    return Route("left", 4.5, 1.8, 100.0, 60.0, (Stage(x, y, np.full(len(x), 15.0)),), (), ())


def test_with_a_route_the_motion_is_assumed_along_it():
    straight, along = Stack("predictive", stands_at=52.0), Stack("predictive", stands_at=52.0)
    along.repair.take_route(messages.route_message_of(route_to_the_left(), header(0.0)))
    assert straight.drive(2.5).repair.intervened  # who stands there is in the way
    answer = along.drive(2.5)
    assert not answer.repair.intervened  # the route turns off before
    assert answer.repair.reason == str(Assumption.ALONG_ROUTE)
    assert along.repair.assumption == str(Assumption.ALONG_ROUTE)


def test_an_unusable_route_is_an_error_that_says_so():
    message = messages.route_message_of(route_to_the_left(), header(0.0))
    message.y = message.y[1:]
    with pytest.raises(ValueError, match="route: the arrays"):
        Stack().repair.take_route(message)


def planned(time, y, frame="odom"):
    """Ahead at 10 m/s, and to the side."""
    ahead = 10.0 * time + 2.5 * np.arange(1.0, 13.0)
    plan = Trajectory(0.25, ahead, np.full(12, y), np.zeros(12), np.full(12, 10.0))
    return messages.trajectory_message_of(plan, header(time, frame))


def test_a_planned_trajectory_is_taken_and_then_nothing_is_assumed():
    stack = Stack("predictive", stands_at=30.0)
    for step in range(100):
        time = 0.01 * step
        stack.ego(time)
        if step % 10 == 0:
            stack.repair.take_trajectory(planned(time, 6.0), time)
            stack.objects(time)
        answer = stack.command(time)
    assert answer.repair.reason == ""
    assert not answer.repair.intervened  # it leads past
    assert stack.repair.assumption == ""
    answer = stack.drive(2.0, 1.0)  # it comes no more
    assert answer.repair.reason.endswith(NOT_TOLD)
    assert answer.repair.intervened
    assert stack.repair.assumption == NOT_TOLD


def test_a_trajectory_in_another_frame_is_not_used_and_named():
    stack = Stack()
    stack.ego(0.0)
    stack.repair.take_trajectory(planned(0.0, 0.0, "map"), 0.0)
    assert "planned trajectory in the frame 'map'" in stack.drive(1.0).repair.reason


@pytest.mark.parametrize(
    ("points", "interval", "status"),
    [
        (None, 0.25, RepairStatus.REPAIRED),
        (0, 0.25, RepairStatus.REPAIRED),
        (12, 1e-5, RepairStatus.INVALID_COMMAND),
        (601, 0.25, RepairStatus.INVALID_COMMAND),
    ],
)
def test_a_trajectory_of_no_use_leaves_the_present_turn_assumed_and_who_is_on_it_is_braked_for(
    points, interval, status
):
    stack = Stack()
    for step in range(20):
        time = 0.05 * step
        stack.ego(time, x=0.0, yaw_rate=0.5)  # on a circle of 20 m
        stack.repair.take_objects(detections(time, detection("7", 13.6, 5.3), frame="odom"), time)
        if points is not None:
            plan = Trajectory(interval, *(np.full(points, value) for value in (30.0, 0.0, 0.0, 10.0)))
            stack.repair.take_trajectory(messages.trajectory_message_of(plan, header(time, "odom")), time)
        answer = stack.command(time)
    assert answer.repair.status is status
    assert answer.repair.command.brake > 0.3
    assert answer.repair.reason.endswith(NOT_TOLD)
    assert ("unusable" in answer.repair.reason) == (status is RepairStatus.INVALID_COMMAND)


def test_a_trajectory_that_came_before_the_odometry_is_looked_at_all_the_same():
    stack = Stack("predictive", stands_at=30.0)
    stack.repair.take_trajectory(planned(0.0, 6.0, "base_link"), 0.0)
    answer = stack.drive(0.25)
    assert "planned trajectory in the frame 'base_link', not in odom: not used" in answer.repair.reason
    assert answer.repair.reason.endswith(NOT_TOLD)
    stack = Stack("predictive", stands_at=30.0)
    stack.repair.take_trajectory(planned(0.0, 6.0), 0.0)
    assert stack.drive(0.25).repair.reason == ""


def test_our_own_messages_do_as_well():
    stack = Stack(form=PedalForm, reader=OwnObjects)
    columns = {"x": 24.0, "y": 0.0, "yaw": 0.0, "speed": 0.0, "acceleration": 0.0, "yaw_rate": 0.0}
    ahead = ObjectList.of(id=[3], kind=1, length=4.5, width=1.8, **columns)
    for step in range(20):
        time = 0.05 * step
        stack.ego(time)
        told = messages.object_message_of(ahead, np.empty(0, dtype=np.uint8), header(time))
        stack.repair.take_objects(told, time)
        asked = messages.command_message_of(Command(0.4, 0.0), header(time))
        answer = stack.repair.take_command(asked, time)
    assert answer.repair.intervened
    assert answer.message.brake == answer.repair.command.brake > 0.2
