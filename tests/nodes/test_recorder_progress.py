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
        self.told, self.listener, self.topics = [], None, set()

    def create_publisher(self, _kind, topic, _profile):
        self.topics.add(topic)
        return SimpleNamespace(publish=lambda message: self.told.append(message.sec * 10**9 + message.nanosec))

    def create_subscription(self, _kind, topic, callback, _profile):
        self.topics.add(topic)
        self.listener = callback

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


def test_where_no_recorder_has_told_nobody_is_behind(wire):
    assert not ProgressWatch(wire, lambda: None).is_behind(ticks(10_000))


def test_a_recorder_is_behind_from_the_lead_on_until_it_tells(wire):
    calls = []
    watch = ProgressWatch(wire, lambda: calls.append(None))
    wire.hear(ticks(3))
    assert not watch.is_behind(ticks(3 + LEAD_TICKS - 1))
    assert watch.is_behind(ticks(3 + LEAD_TICKS))
    wire.hear(ticks(4))
    assert not watch.is_behind(ticks(3 + LEAD_TICKS))
    assert len(calls) == 2
    watch.forget()
    assert not watch.is_behind(ticks(10_000))


def test_both_speak_of_one_topic_and_it_is_hidden(wire):
    ProgressReport(wire)
    ProgressWatch(wire, lambda: None)
    assert wire.topics == {topics.RECORDER_PROGRESS}
    assert "/_" in topics.RECORDER_PROGRESS


def test_reports_come_often_enough_for_the_lead():
    assert 2 * REPORT_TICKS <= LEAD_TICKS
