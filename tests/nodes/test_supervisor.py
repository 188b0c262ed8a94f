"""Who hangs is ended, who ended is started anew, and both are on the record; with real processes that a signal stops."""

import os
import signal
import time
from types import SimpleNamespace

import pytest

from roadmend.core.errors import RoadmendError
from roadmend.nodes.children import Child
from roadmend.nodes.heartbeat import SETTLED_BEATS, Pulse
from roadmend.nodes.supervisor import FRESH_S, RESTARTS_MAX, Supervisor

MODULE = """
import time
from roadmend.nodes.heartbeat import Heartbeat

def main(arguments):
    heart = Heartbeat()
    while True:
        heart.beat()
        time.sleep(0.02)
"""


class Fake:
    """A child whose life is in the test's hands."""

    def __init__(self, tmp_path):
        self.name, self.exit_code, self.process, self.hung, self.restarts = "policy_node", None, object(), "", 0
        self.pulse, self.now, self.beats = Pulse(tmp_path / "policy.beat"), 0.0, 0

    def kill(self, why):
        self.hung, self.exit_code = why, -9

    def fault(self):
        return RoadmendError(self.hung)

    def start(self):
        self.hung, self.exit_code = "", None
        self.pulse.begin()

    def live(self, supervisor, seconds, *, is_driving=True, beats=True):
        for _ in range(round(seconds / 0.25)):
            self.now += 0.25
            if beats:
                self.beats += 1
                self.pulse.path.touch()
                os.utime(self.pulse.path, ns=(self.beats, self.beats))
            supervisor.end_silent([self], self.now, is_driving=is_driving)
        return self.exit_code is None


@pytest.fixture
def fake(tmp_path):
    return Fake(tmp_path)


@pytest.mark.parametrize(
    ("beats", "is_driving", "limit"),
    [
        (SETTLED_BEATS, True, 5.0),
        (1, True, FRESH_S),
        (0, True, FRESH_S),
        (SETTLED_BEATS, False, 50.0),
        (0, False, 50.0),
    ],
)
def test_how_long_a_silence_is_borne_depends_on_where_the_run_and_the_node_are(fake, beats, is_driving, limit):
    supervisor = Supervisor(5.0, 50.0)
    assert fake.live(supervisor, 0.25 * beats, is_driving=is_driving)
    assert fake.live(supervisor, limit, is_driving=is_driving, beats=False)
    assert not fake.live(supervisor, 1.0, is_driving=is_driving, beats=False)
    assert fake.hung == f"hung: no sign of life for {limit:g} s"
    assert supervisor.restart(fake) == f"policy_node {words(limit)}, restarted"
    assert supervisor.faults == [f"policy_node {words(limit)}, restarted"]


def words(limit):
    return f"hung: no sign of life for {limit:g} s"


def test_who_ends_too_often_ends_the_run(fake):
    supervisor = Supervisor(5.0)
    for number in range(1, RESTARTS_MAX + 1):
        fake.exit_code = -11
        assert supervisor.restart(fake) == "policy_node ended (-11), restarted"
        assert fake.restarts == number
    with pytest.raises(RoadmendError, match=f"policy_node ended {RESTARTS_MAX + 1} times"):
        supervisor.restart(fake)


@pytest.fixture
def beater(tmp_path, monkeypatch):
    """Makes processes of their own that beat."""
    (tmp_path / "beats_for_ever.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    made = []

    def make(name):
        child = Child(name, "beats_for_ever", [], {}, tmp_path / f"{name}.log", may_restart=True)
        child.start()
        made.append(child)
        deadline = time.monotonic() + 100.0
        while not child.pulse.beats and time.monotonic() < deadline:
            child.pulse.look(time.monotonic())
            time.sleep(0.02)
        return child

    yield make
    for child in made:
        child.kill("the test is over")


def test_who_falls_silent_just_before_the_end_does_not_answer_it_and_is_named(beater):
    well, hung, dead = beater("well_node"), beater("hung_node"), beater("dead_node")
    os.kill(hung.process.pid, signal.SIGSTOP)
    dead.process.kill()
    dead.process.join()
    supervisor = Supervisor(1.0)
    supervisor.end([well, hung, dead])
    assert supervisor.faults == [
        "dead_node ended (-9), at the end",
        "hung_node hung: no sign of life for 1 s, at the end",
    ]
    assert None not in {child.exit_code for child in (well, hung, dead)}


def test_who_is_hurried_blames_nobody(beater):
    child = beater("slow_node")
    os.kill(child.process.pid, signal.SIGSTOP)
    supervisor, begin = Supervisor(60.0), time.monotonic()
    supervisor.end([child], lambda: True)
    assert supervisor.faults == []
    # Where it had not yet stopped when the interrupt came, that ended it: it has no handler.
    assert child.exit_code in {-signal.SIGKILL, -signal.SIGINT}
    assert time.monotonic() - begin < 30.0


def test_a_process_that_is_stopped_is_killed_and_says_why(tmp_path, monkeypatch):
    (tmp_path / "beats_for_ever.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    child = Child("beater", "beats_for_ever", [], {}, tmp_path / "beater.log", may_restart=True)
    supervisor = Supervisor(1.0)

    def until(done):
        deadline = time.monotonic() + 100.0
        while not done() and time.monotonic() < deadline:
            supervisor.end_silent([child], time.monotonic(), is_driving=True)
            time.sleep(0.02)
        assert done(), child.log.read_text()

    child.start()
    try:
        until(lambda: child.pulse.is_settled)
        assert child.exit_code is None
        os.kill(child.process.pid, signal.SIGSTOP)
        until(lambda: child.exit_code is not None)
        assert (child.exit_code, str(child.fault())) == (-signal.SIGKILL, "hung: no sign of life for 1 s")
        supervisor.restart(child)
        until(lambda: child.pulse.is_settled)
        assert (child.exit_code, child.hung) == (None, "")
    finally:
        child.kill("the test is over")


def test_processes_that_are_not_there_are_left_alone(tmp_path):
    never = SimpleNamespace(exit_code=None, process=None)
    ended = SimpleNamespace(exit_code=1, process=object())
    Supervisor(0.1).end_silent([never, ended], 0.0, is_driving=True)
