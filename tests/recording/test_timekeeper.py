import time

import pytest

from roadmend.recording.definitions import find
from roadmend.recording.timekeeper import Timekeeper

SECOND = 10**9
TODAY = 1_800_000_000 * SECOND


@pytest.fixture
def times(make):
    """Returns the time that a keeper gives to a message of the type with that stamp."""

    def give(keeper, type_name, time_ns=0):
        message = make(type_name) if "String" in type_name else make.stamped(type_name, time_ns)
        return keeper.rule_for(find(type_name))(make.cdr(message))

    return give


CLOCK, COMMAND, TEXT = "rosgraph_msgs/msg/Clock", "roadmend_msgs/msg/Command", "std_msgs/msg/String"


@pytest.mark.parametrize("time_ns", [0, 1, SECOND - 1, SECOND, 25_200 * SECOND + 50_000_000])
def test_a_header_and_a_clock_carry_their_time(times, time_ns):
    keeper = Timekeeper()
    assert times(keeper, COMMAND, time_ns) == time_ns
    assert times(keeper, CLOCK, time_ns) == time_ns == keeper.now_ns


def test_without_a_header_the_clock_counts(times):
    keeper = Timekeeper()
    assert times(keeper, TEXT) == 0
    times(keeper, CLOCK, 3 * SECOND)
    times(keeper, COMMAND, 9 * SECOND)
    assert times(keeper, TEXT) == 3 * SECOND


def test_a_clock_that_runs_back_is_followed(times):
    keeper = Timekeeper()
    times(keeper, CLOCK, 3 * SECOND)
    times(keeper, CLOCK, 1 * SECOND)
    assert times(keeper, TEXT) == SECOND


def test_a_wall_clock_stamp_in_a_simulation_is_not_believed_and_counted(times):
    keeper = Timekeeper()
    times(keeper, CLOCK, 3 * SECOND)
    assert times(keeper, COMMAND, TODAY) == 3 * SECOND
    assert keeper.wall_stamps == 1


def test_where_the_clock_is_a_wall_clock_its_stamps_are_believed(times):
    keeper = Timekeeper()
    times(keeper, CLOCK, TODAY)
    assert times(keeper, COMMAND, TODAY + 5) == TODAY + 5
    assert keeper.wall_stamps == 0


@pytest.mark.parametrize("told", [(COMMAND, TODAY), (COMMAND, 0), (COMMAND, -SECOND), (CLOCK, 12 * SECOND), (TEXT,)])
def test_without_simulation_a_message_belongs_to_the_moment_at_which_it_came(times, told):
    before = time.time_ns()
    assert before <= times(Timekeeper(simulated=False), *told) <= time.time_ns()


def test_a_stamp_before_time_began_counts_as_no_stamp(times):
    keeper = Timekeeper()
    times(keeper, CLOCK, 3 * SECOND)
    assert times(keeper, COMMAND, -SECOND) == 3 * SECOND
    assert times(keeper, CLOCK, -SECOND) == 0


def test_without_simulation_the_clock_is_followed_all_the_same(times):
    keeper = Timekeeper(simulated=False)
    times(keeper, CLOCK, 12 * SECOND)
    assert keeper.now_ns == 12 * SECOND


def test_a_stamp_of_zero_is_that_of_a_simulation_that_begins(times):
    assert times(Timekeeper(), COMMAND, 0) == 0
