"""One writer a topic: its numbers go on, a stranger's do not, and in doubt nobody is obeyed."""

import random
import time
from types import SimpleNamespace

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from roadmend_msgs.msg import Command

from roadmend.nodes import qos
from roadmend.nodes.inputs import COMMAND, Input
from roadmend.nodes.numbered_input import NumberedInput
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
    assert right >= 192  # not for the moment in which they pass each other


@pytest.mark.parametrize("first", [1, 190, 196, 199, 200, 201, 205])
@pytest.mark.parametrize("is_before", [False, True])
@pytest.mark.parametrize("missed", [0, 3, 7])
def test_a_stranger_as_fast_as_the_writer_is_not_obeyed_in_its_place(first, is_before, missed):
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 200))
    gate.see([THEIRS, OURS])
    ours, wrong = 200, 0
    for step in range(400):
        both = [(first + step, True), (ours, False)]
        for number, is_theirs in both if is_before else both[::-1]:
            if is_theirs or not 20 <= step < 20 + missed:  # it does not answer every tick
                wrong += gate.admits(number, 0.05 * (200 + step)) and is_theirs
                ours += not is_theirs
    assert wrong <= 1


def beats(rate, count, chance, jitter):
    """Times of messages in their order."""
    return sorted(10.0 + 0.05 * step / rate + chance.uniform(0.0, jitter) for step in range(count))


@pytest.mark.parametrize("speed", [1.05, 1.1, 1.25, 1.5, 3.0, 10.0])
@pytest.mark.parametrize("jitter", [0.0, 0.03])
@pytest.mark.parametrize("seed", range(3))
def test_nor_is_one_that_is_faster_whatever_comes_first(speed, jitter, seed):
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 200))
    gate.see([THEIRS, OURS])
    chance = random.Random(seed)
    sent = [(time, 200 + step, False) for step, time in enumerate(beats(1.0, 6000, chance, jitter))]
    sent += [(time, 1 + step, True) for step, time in enumerate(beats(speed, round(6000 * speed), chance, jitter))]
    admitted = [(number, is_theirs) for now, number, is_theirs in sorted(sent) if gate.admits(number, now)]
    assert sum(is_theirs for _, is_theirs in admitted) <= 1
    assert admitted[-1] == (6199, False)  # once they are apart again, as before
    assert len(admitted) > 5800


def test_a_stranger_of_long_ago_brings_no_doubt_upon_the_writer():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 101))
    gate.see([OURS, THEIRS])
    assert not gate.admits(140, 5.0)
    gate.see([OURS])
    assert obeyed(gate, range(101, 141), begin=5.0) == [*range(101, 141)]
    gate.see([OURS, THEIRS])
    assert obeyed(gate, range(141, 160), begin=7.0) == [*range(141, 160)]


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


def test_who_takes_the_place_of_a_named_writer_is_not_obeyed_and_named():
    gate = WriterGate("policy_node")
    gate.see([OURS])
    obeyed(gate, range(1, 101))
    gate.see([THEIRS])
    assert obeyed(gate, [1, 2, 101, 102], begin=5.0) == []
    assert gate.strangers == (THEIRS,)


def test_without_a_name_who_comes_once_the_writer_has_gone_is_obeyed_unless_he_was_there_beside_it():
    gate = WriterGate()
    gate.see(["/mine"])
    gate.see(["/mine", THEIRS])
    gate.see([THEIRS])
    assert obeyed(gate, [500, 501]) == []
    gate.see([])
    gate.see([""])  # of whom DDS has not told yet who he is
    gate.see([OURS])
    assert (gate.writer, obeyed(gate, [1, 2])) == ("policy_node", [1, 2])


class Told(Input):
    """An input of which the test says who publishes, and that keeps how often that was asked."""

    there, asked = (OURS,), 0

    def endpoints(self, _node):
        Told.asked += 1
        return [*Told.there]


@pytest.fixture
def gated(node, monkeypatch):
    """A gated input whose messages come from the test: each of the numbers; returns those that were taken."""
    monkeypatch.setattr(Told, "there", (OURS,))
    monkeypatch.setattr(Told, "asked", 0)
    monkeypatch.setattr(NumberedInput, "publishers", 1)
    reader, got = node("reader"), []
    one = GatedInput(
        reader, Told(COMMAND.topic, COMMAND.type_name, COMMAND.request), Command, "policy_node", got.append, lambda: 0.0
    )

    def send(numbers):
        before = len(got)
        for number in numbers:
            one._on_message(number, number)
        return got[before:]

    return SimpleNamespace(send=send, one=one)


def test_who_publishes_is_not_asked_for_each_message(gated):
    gated.one._look_again()
    assert Told.asked == 0  # nobody has spoken
    assert gated.send(range(1, 1001)) == [*range(1, 1001)]
    assert Told.asked == 1
    assert gated.send([1003]) == [1003]  # two were lost
    assert Told.asked == 2
    Told.there = (OURS, THEIRS)
    gated.one._look_again()
    gated.send([1, 1004, 2, 1005])
    assert Told.asked == 3


def test_of_a_middleware_that_does_not_number_messages_who_publishes_is_not_asked_for_each_either(gated):
    assert len(gated.send([0] * 100)) == 100
    assert Told.asked == 1


@pytest.mark.parametrize("numbers", [[1, 2, 3], [101, 102], [0, 0]])
def test_who_took_the_writers_place_unseen_is_not_obeyed(gated, numbers):
    gated.send(range(1, 101))
    Told.there = (THEIRS,)
    if numbers[0] == 101:  # they happen to follow
        gated.one._look_again()
    assert gated.send(numbers) == []
    assert gated.one.gate.strangers == (THEIRS,)
    assert "/intruder publishes too, and is not obeyed; only policy_node is" in gated.one.warning


def publish_until(done, executor, publisher, throttle):
    deadline = time.monotonic() + 60.0
    while not done() and time.monotonic() < deadline:
        publisher.publish(Command(throttle=throttle))
        time.sleep(0.01)
        executor.spin_once(timeout_sec=0.05)
    assert done()


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

        publish_until(lambda: len(got) > FIRST + 10, executor, mine, 0.1)
        assert one.warning == ""
        other = theirs.create_publisher(Command, topics.POLICY_COMMAND, qos.COMMAND)
        publish_until(lambda: one.gate.refused > 2, executor, other, 0.9)
        number = len(got)
        publish_until(lambda: len(got) > number + 2, executor, mine, 0.2)
        assert {message.throttle for message in got} == {0.1, 0.2}
        assert "/intruder publishes too, and is not obeyed; only policy_node is" in one.warning
    finally:
        executor.shutdown()


def test_a_writer_of_before_has_its_place_again_when_it_is_alone():
    gate = WriterGate()
    gate.see([OURS])
    assert gate.admits(1, 0.0)
    gate.see([])
    gate.see([THEIRS])  # an operator steps in
    assert gate.admits(1, 1.0)
    gate.see([THEIRS, OURS])
    assert gate.strangers == (OURS,)
    gate.see([OURS])
    assert gate.strangers == ()
    assert gate.admits(1, 2.0)


def test_who_was_a_stranger_beside_the_writer_stays_one_over_a_look_at_nobody():
    gate = WriterGate()
    gate.see([OURS])
    assert gate.admits(1, 0.0)
    gate.see([OURS, THEIRS])
    gate.see([])
    gate.see([THEIRS])
    assert gate.strangers == (THEIRS,)
    assert not gate.admits(50, 1.0)


def test_over_dds_who_takes_the_writers_place_between_two_messages_is_not_heard(node):
    reader, ours, theirs = node("reader"), node("policy_node"), node("intruder")
    executor = EventsExecutor(context=reader.context)
    executor.add_node(reader)
    got = []
    one = GatedInput(
        reader, COMMAND, Command, "policy_node", lambda data: got.append(messages.COMMAND.decode(data)), time.monotonic
    )

    try:
        mine = ours.create_publisher(Command, topics.POLICY_COMMAND, qos.COMMAND)
        publish_until(lambda: len(got) > 2, executor, mine, 0.1)
        ours.destroy_publisher(mine)
        other = theirs.create_publisher(Command, topics.POLICY_COMMAND, qos.COMMAND)
        publish_until(lambda: one.gate.refused > 2, executor, other, 0.9)
        assert {message.throttle for message in got} == {0.1}
        assert "/intruder" in one.warning
    finally:
        executor.shutdown()
