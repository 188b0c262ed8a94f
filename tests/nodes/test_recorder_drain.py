"""What a recorder still takes in once it was told to stop: when it ends, and what it says of its end."""

import time
from types import SimpleNamespace

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from roadmend_msgs.msg import Command

from roadmend.nodes import recorder, recorder_drain
from roadmend.nodes.recorder_drain import LOOK_S, QUIET_S, REPAIR_S, drain
from roadmend.recording.reader import BagReader

EARLIER, LATER = -1.0, 3600.0  # [s] from now at which a message was sent


class Subscription:
    """Stands in for a subscription: what comes at each look, by when it was sent; nothing behind the end."""

    msg_type = Command

    def __init__(self, clock, sent):
        self.clock, self.sent, self.handle = clock, sent, self
        self.came = {}  # messages by look

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def take_message(self, kind, raw):
        assert (kind, raw) == (Command, True)
        look = self.clock.looks
        if self.came.get(look) or not self.sent(look):
            return None
        self.came[look] = True
        return b"message", {"source_timestamp": time.time_ns() + round(self.sent(look) * 1e9)}


@pytest.fixture
def clock(monkeypatch):
    """Wall time that passes in sleep alone."""
    clock = SimpleNamespace(looks=0, now=0.0)

    def sleep(seconds):
        clock.now += seconds
        clock.looks += 1

    fake = SimpleNamespace(monotonic=lambda: clock.now, sleep=sleep, time_ns=time.time_ns)
    monkeypatch.setattr(recorder_drain, "time", fake)
    return clock


def run(clock, sent, limit, *, others=True):
    """Drain one subscription; returns whether it came to its end, how many messages it took, and how long [s]."""
    taken = []
    subscription = Subscription(clock, sent)
    return drain([(subscription, taken.append)], lambda: others, limit), len(taken), clock.now


def test_where_all_publishers_have_gone_a_short_silence_is_the_end(clock):
    assert run(clock, lambda look: EARLIER if look < 3 else None, 15.0, others=False) == (
        True,
        3,
        pytest.approx(QUIET_S, abs=4 * LOOK_S),
    )


def test_a_message_that_dds_brings_after_seconds_is_waited_for_again_and_again(clock):
    round_ = round(3.0 / LOOK_S)
    finished, count, lasted = run(
        clock, lambda look: EARLIER if look in {round_, 2 * round_, 3 * round_} else None, 15.0
    )
    assert (finished, count) == (True, 3)
    assert lasted == pytest.approx(9.0 + REPAIR_S, abs=3 * LOOK_S)


def test_what_was_sent_later_is_taken_but_keeps_nobody_waiting(clock):
    finished, count, lasted = run(clock, lambda _: LATER, 60.0)
    assert finished
    assert count == pytest.approx(REPAIR_S / LOOK_S, abs=3)
    assert lasted == pytest.approx(REPAIR_S, abs=3 * LOOK_S)


def test_the_limit_ends_what_would_not_end_and_that_is_said(clock):
    finished, _, lasted = run(clock, lambda _: EARLIER, 5.0)
    assert not finished
    assert lasted == pytest.approx(5.0, abs=2 * LOOK_S)


def test_a_limit_below_the_time_that_dds_takes_says_nothing_where_nothing_came(clock):
    assert run(clock, lambda _: None, 1.0) == (True, 0, pytest.approx(1.0, abs=2 * LOOK_S))


def test_what_came_at_once_is_not_what_still_comes_at_the_limit(clock):
    assert run(clock, lambda look: EARLIER if look < 3 else None, 1.0) == (True, 3, pytest.approx(1.0, abs=2 * LOOK_S))


def test_a_machine_that_hardly_lets_it_look_does_not_end_it(clock, monkeypatch):
    def starved(_seconds):
        clock.now += 1.0
        clock.looks += 1

    monkeypatch.setattr(recorder_drain.time, "sleep", starved)
    assert run(clock, lambda look: EARLIER if look == 5 else None, 60.0, others=False)[:2] == (True, 1)


def test_a_bag_that_was_closed_at_the_limit_says_so(domain, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(recorder, "drain", lambda *_: False)
    words = ["--ros-args", "-p", f"output:={tmp_path}", "-p", "name:=bag", "-p", "drain_limit:=0.5"]
    rclpy.init(args=["test", *words], domain_id=domain)
    try:
        node = recorder.RecorderNode()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        node.close()
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    said = "closed after 0.5 s while messages sent before still came; raise the parameter drain_limit"
    assert said in capfd.readouterr().err
    told = BagReader(tmp_path / "bag").metadata["roadmend"]
    assert told["incomplete"] == "closed while messages sent before still came"
