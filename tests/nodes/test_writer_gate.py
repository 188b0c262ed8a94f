"""One writer a topic: its numbers go on, a stranger's do not, and in doubt nobody is obeyed."""

import time

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from roadmend_msgs.msg import Command

from roadmend.nodes import qos
from roadmend.nodes.inputs import COMMAND
from roadmend.nodes.writer_gate import FIRST, GAP, GatedInput, WriterGate
from roadmend.recording import messages, topics

OURS, THEIRS = "/policy_node", "/intruder"


def obeyed(gate, numbers, *, every=0.05, begin=0.0):
    return [number for step, number in enumerate(numbers) if gate.admits(number, begin + every * step)]


def test_a_writer_alone_is_obeyed_whatever_its_numbers():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    assert obeyed(gate, [1, 2, 700, 3]) == [1, 2, 700, 3]
    assert (gate.strangers, gate.refused) == ((), 0)


def test_a_stranger_that_comes_later_is_not_obeyed_and_the_writer_is():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 101))
    gate.see([OURS, THEIRS])
    mixed = [number for step in range(50) for number in (step + 1, 101 + step)]
    assert obeyed(gate, mixed, begin=5.0, every=0.025) == [*range(101, 151)]
    assert (gate.strangers, gate.refused) == ((THEIRS,), 50)


@pytest.mark.parametrize("speed", [2, 5])
def test_a_stranger_that_is_faster_does_not_take_over_where_its_numbers_pass_the_writers(speed):
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 141))
    gate.see([THEIRS, OURS])
    theirs, wrong, right = 0, 0, 0
    for ours in range(141, 341):
        for _ in range(speed):
            theirs += 1
            wrong += gate.admits(theirs, 0.05 * ours)
        right += gate.admits(ours, 0.05 * ours + 0.01)
    assert wrong <= 1
    assert right >= 198


def test_numbers_that_jump_are_a_strangers_and_lost_messages_are_not():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 11))
    gate.see([OURS, THEIRS])
    assert obeyed(gate, [500, 11, 12 + GAP, 900], begin=0.5) == [11, 12 + GAP]
    assert gate.admits(200, 2.0)  # a second and more, of which nothing came


def test_a_silent_stranger_disturbs_nobody_from_the_first_message_on():
    gate = WriterGate("policy_node")
    gate.see([THEIRS, OURS])
    assert obeyed(gate, range(1, 30)) == [*range(1, 30)]


def test_where_it_cannot_be_told_who_speaks_nobody_is_obeyed():
    gate = WriterGate("policy_node")
    gate.see([THEIRS])
    assert obeyed(gate, range(1, 5)) == []
    gate.see([THEIRS, OURS])
    assert obeyed(gate, [FIRST + 100, FIRST + 101]) == []
    gate.see([OURS, ""])
    assert gate.strangers == ("",)


def test_two_that_begin_together_are_told_apart_by_nothing_and_none_is_obeyed_until_one_has_gone():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 4))
    gate.see([OURS, THEIRS])
    both = [number for number in range(4, 60) for _ in range(2)]
    assert obeyed(gate, both, begin=0.2, every=0.025) == [4]
    gate.see([OURS])
    assert obeyed(gate, range(60, 63), begin=5.0) == [60, 61, 62]


def test_a_writer_that_is_started_anew_begins_with_new_numbers():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 301))
    gate.see([OURS, THEIRS])
    gate.see([OURS, OURS, THEIRS])  # the dead one is seen for a while yet
    assert obeyed(gate, [1, 2, 3], begin=20.0) == [1, 2, 3]


def test_without_a_name_whoever_is_there_alone_first_is_obeyed():
    gate = WriterGate()
    gate.see([THEIRS, OURS])
    assert obeyed(gate, [1, 2]) == []
    gate.see(["/mine"])
    assert gate.writer == "mine"
    assert obeyed(gate, [70]) == [70]
    gate.see(["/mine", OURS])
    assert obeyed(gate, [1, 71, 2], begin=0.05) == [71]


@pytest.mark.parametrize("kind", [EventsExecutor, SingleThreadedExecutor])
def test_over_dds_only_the_writer_is_heard_and_the_other_is_named(node, kind):
    reader, ours, theirs = node("reader"), node("policy_node"), node("intruder")
    executor = kind(context=reader.context)
    executor.add_node(reader)
    got = []
    one = GatedInput(
        reader, COMMAND, Command, "policy_node", lambda data: got.append(messages.COMMAND.decode(data)), time.monotonic
    )
    try:
        mine = ours.create_publisher(Command, topics.POLICY_COMMAND, qos.COMMAND)

        def until(done, publisher, throttle):
            deadline = time.monotonic() + 60.0
            while not done() and time.monotonic() < deadline:
                publisher.publish(Command(throttle=throttle))
                time.sleep(0.01)
                executor.spin_once(timeout_sec=0.05)
            assert done()

        until(lambda: len(got) > FIRST + 10, mine, 0.1)
        assert one.warning == ""
        other = theirs.create_publisher(Command, topics.POLICY_COMMAND, qos.COMMAND)
        until(lambda: one.gate.refused > 2, other, 0.9)
        number = len(got)
        until(lambda: len(got) > number + 2, mine, 0.2)
        assert {message.throttle for message in got} == {0.1, 0.2}
        assert "/intruder publishes too, and is not obeyed; only policy_node is" in one.warning
    finally:
        executor.shutdown()
