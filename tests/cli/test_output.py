"""Progress where there is no terminal: a line now and then, and no more."""

import io
import re
import time

import pytest
from rich.console import Console

from roadmend.cli import output
from roadmend.cli.output import ProgressLines, Waiting, counting, stage_of


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand; progress has no other."""
    now = [1000.0]
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    return now


@pytest.fixture(autouse=True)
def pace(monkeypatch):
    """The one that people get; the other tests here have theirs."""
    monkeypatch.setattr(output, "_SILENCE", 30.0)
    monkeypatch.setattr(output, "_PAUSE", 5.0)


@pytest.fixture
def told():
    return io.StringIO()


def lines_of(told, total, steps, clock, seconds):
    with ProgressLines(Console(file=told)) as progress:
        task = progress.add_task("episodes [1/2]", total=total)
        for done in range(1, steps + 1):
            clock[0] += seconds
            progress.update(task, completed=done)
    return told.getvalue().splitlines()


def test_a_line_for_every_tenth(clock, told):
    lines = lines_of(told, 1000, 1000, clock, 0.1)
    assert [line.partition(" after")[0] for line in lines] == [
        f"episodes [1/2]: {done:,} of 1,000" for done in range(100, 1001, 100)
    ]
    assert lines[-1] == "episodes [1/2]: 1,000 of 1,000 after 100 s"


def test_what_is_done_at_once_says_nothing(clock, told):
    assert lines_of(told, 50, 50, clock, 0.001) == []


def test_what_takes_longer_says_when_it_is_done(clock, told):
    assert lines_of(told, 50, 50, clock, 0.11)[-1] == "episodes [1/2]: 50 of 50 after 6 s"


def test_what_is_slow_has_a_line_now_and_then(clock, told):
    lines = lines_of(told, 100_000, 100, clock, 10.0)
    assert len(lines) == 33
    assert lines[0].startswith("episodes [1/2]: 3 of 100,000 after 30 s")


def test_what_has_no_end_is_told_too(clock, told):
    assert lines_of(told, None, 4, clock, 20.0)[0] == "episodes [1/2]: 2 after 40 s"


def test_nothing_is_said_of_what_does_not_move(clock, told):
    with ProgressLines(Console(file=told)) as progress:
        task = progress.add_task("episodes", total=10)
        for _ in range(5):
            clock[0] += 100.0
            progress.update(task, description="still")
    assert told.getvalue() == ""


def test_a_task_that_begins_anew_is_told_anew(clock, told):
    with ProgressLines(Console(file=told)) as progress:
        clock[0] += 10.0
        task = progress.add_task("S1", total=2)
        progress.update(task, completed=2)
        clock[0] += 1.0
        progress.reset(task, description="S2", total=2)
        progress.update(task, completed=2)
    assert told.getvalue().splitlines() == ["S1: 2 of 2 after 10 s", "S2: 2 of 2 after 11 s"]


def test_one_bar_for_all_stages_begins_anew_with_each(clock, told):
    with ProgressLines(Console(file=told)) as progress:
        report = stage_of(progress)
        for what, total in (("episodes", 100), ("bags", 2), ("bags", 2)):
            for done in range(1, total + 1):
                clock[0] += 10.0
                report(what, done, total)
    lines = [line.partition(" after")[0] for line in told.getvalue().splitlines()]
    assert lines[-5:] == ["episodes: 100 of 100", "bags: 1 of 2", "bags: 2 of 2", "bags: 1 of 2", "bags: 2 of 2"]


def test_without_a_terminal_counting_gives_lines(capfd, monkeypatch):
    monkeypatch.setattr(output, "_PAUSE", 0.0)
    with counting() as progress:
        task = progress.add_task("episodes", total=2)
        progress.advance(task)
        progress.advance(task)
    printed = capfd.readouterr()
    assert printed.out == ""
    assert re.fullmatch(r"episodes: 1 of 2 after .*\nepisodes: 2 of 2 after \d+ s\n", printed.err)


def test_what_cannot_be_counted_says_now_and_then_that_it_is_at_work(capfd, monkeypatch):
    monkeypatch.setattr(output, "_SILENCE", 0.05)
    with Waiting("[town] · rss") as waiting:
        waiting.update("3 s")
        time.sleep(0.4)
        waiting.say("ended")
    lines = capfd.readouterr().err.splitlines()
    assert lines[-1] == "[town] · rss: ended"
    assert set(lines[:-1]) == {"[town] · rss: 3 s"}
