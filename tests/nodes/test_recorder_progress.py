"""How far the recorder has come: who tells it when, and who is waited for."""

from types import SimpleNamespace

import pytest
from builtin_interfaces.msg import Time

from roadmend.core.tick import INTERVAL_NS
from roadmend.nodes.recorder_progress import LEAD_TICKS, REPORT_TICKS, ProgressReport, ProgressWatch
from roadmend.recording import topics


class Wire:
    """Stands in for a node: what is published on it and who listens."""

    def __init__(self):
        self.told, self.listener, self.topics, self.warned = [], None, set(), []

    def create_publisher(self, _kind, topic, _profile):
        self.topics.add(topic)
        return SimpleNamespace(publish=lambda message: self.told.append(message.sec * 10**9 + message.nanosec))

    def create_subscription(self, _kind, topic, callback, _profile):
        self.topics.add(topic)
        self.listener = callback

    def get_logger(self):
        return SimpleNamespace(warning=self.warned.append)

    def hear(self, now_ns):
        self.listener(Time(sec=now_ns // 10**9, nanosec=now_ns % 10**9))


def ticks(number):
    return number * INTERVAL_NS


@pytest.fixture
def wire():
    return Wire()


def test_a_report_comes_with_the_first_tick_and_then_after_some_each(wire):
    report = ProgressReport(wire)
    for number in range(3 * REPORT_TICKS + 1):
        report.see(ticks(number))
    assert wire.told == [ticks(number) for number in range(0, 3 * REPORT_TICKS + 1, REPORT_TICKS)]


def test_a_clock_that_goes_back_is_news_at_once(wire):
    report = ProgressReport(wire)
    report.see(ticks(400))
    report.see(ticks(0))
    assert wire.told == [ticks(400), ticks(0)]


def test_what_is_written_is_told_in_the_end_however_little_it_is_but_once(wire):
    report = ProgressReport(wire)
    report.see(ticks(0))
    report.see(ticks(1))
    report.tell(ticks(1))
    report.tell(ticks(1))
    assert wire.told == [ticks(0), ticks(1)]


def test_where_no_recorder_has_told_nobody_is_waited_for(wire):
    assert not ProgressWatch(wire, 5.0, lambda: None).holds(ticks(10_000), 0.0)


def test_a_tick_waits_from_the_lead_on_until_the_recorder_tells(wire):
    calls = []
    watch = ProgressWatch(wire, 5.0, lambda: calls.append(None))
    wire.hear(ticks(3))
    assert not watch.holds(ticks(3 + LEAD_TICKS - 1), 0.0)
    assert watch.holds(ticks(3 + LEAD_TICKS), 0.0)
    wire.hear(ticks(4))
    assert not watch.holds(ticks(3 + LEAD_TICKS), 0.0)
    assert len(calls) == 2


def test_patience_ends_with_a_word_and_begins_anew_when_the_recorder_tells_again(wire):
    watch = ProgressWatch(wire, 5.0, lambda: None)
    wire.hear(ticks(3))
    assert watch.holds(ticks(10_000), 5.0)
    assert not wire.warned
    assert not watch.holds(ticks(10_000), 5.1)
    assert not watch.holds(ticks(10_001), 0.0)
    assert wire.warned == ["the recorder has written nothing for 5 s: it goes on without it"]
    wire.hear(ticks(4))
    assert watch.holds(ticks(10_002), 0.0)


def test_both_speak_of_one_topic_and_it_is_hidden(wire):
    ProgressReport(wire)
    ProgressWatch(wire, 5.0, lambda: None)
    assert wire.topics == {topics.RECORDER_PROGRESS}
    assert "/_" in topics.RECORDER_PROGRESS


def test_reports_come_often_enough_for_the_lead():
    assert 2 * REPORT_TICKS <= LEAD_TICKS
