"""Signs of life: what a node leaves, and how long a silence the launcher makes of it."""

import os
import time

import pytest

from roadmend.nodes.heartbeat import AWAKE_S, HEARTBEAT_FILE, SETTLED_BEATS, Heartbeat, Pulse


@pytest.fixture
def pulse(tmp_path):
    return Pulse(tmp_path / "node.beat")


def beat(pulse, number):
    pulse.path.touch()
    os.utime(pulse.path, ns=(number, number))


def test_silence_is_counted_from_the_last_beat(pulse):
    pulse.begin()
    for number in range(1, 4):
        beat(pulse, number)
        pulse.look(10.0 + number)
        assert (pulse.silence, pulse.beats) == (0.0, number)
    for step in range(10):
        pulse.look(13.0 + 0.3 * (step + 1))
    assert pulse.silence == pytest.approx(3.0)


def test_who_never_beats_is_silent_from_the_first_look_on(pulse):
    pulse.begin()
    for step in range(11):
        pulse.look(50.0 + 0.2 * step)
    assert (pulse.silence, pulse.beats) == (pytest.approx(2.0), 0)


def test_what_the_launcher_has_slept_is_nobodys_silence(pulse):
    pulse.begin()
    beat(pulse, 1)
    pulse.look(1.0)
    pulse.look(1000.0)
    assert pulse.silence == AWAKE_S


def test_a_new_process_begins_anew(pulse):
    for number in range(1, SETTLED_BEATS + 1):
        assert not pulse.is_settled
        beat(pulse, number)
        pulse.look(float(number))
    assert pulse.is_settled
    pulse.begin()
    assert not pulse.path.exists()
    assert (pulse.beats, pulse.silence, pulse.is_settled) == (0, 0.0, False)


def test_a_node_touches_its_file_each_period_and_none_without_one(tmp_path, monkeypatch):
    monkeypatch.delenv(HEARTBEAT_FILE, raising=False)
    Heartbeat().beat()
    assert list(tmp_path.iterdir()) == []
    file = tmp_path / "a.beat"
    monkeypatch.setenv(HEARTBEAT_FILE, str(file))
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    heart = Heartbeat()
    heart.beat()
    assert file.exists()
    file.unlink()
    heart.beat()
    assert not file.exists()  # it is too early
    now = 101.0
    heart.beat()
    assert file.exists()
    monkeypatch.setenv(HEARTBEAT_FILE, str(tmp_path / "gone" / "a.beat"))
    Heartbeat().beat()  # the launcher and its folder have gone: no reason to fail
