"""The hindsight bound on a collision that is certain: a driver who looks at nothing."""

import json

import pytest

from harness import hindsight_file
from harness.hindsight import Bound, PulseSearch
from harness.hindsight_file import hindsight_bound
from harness.pulse import PulsePlayer
from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.core.parameters import NoParameters
from roadmend.policies.registry import POLICIES, PolicyEntry
from roadmend.world.runner import run_episode
from tests.training.cases import Drawn


class Blind:
    """Keeps to one speed."""

    name = "blind"

    def reset(self, route):
        self._aim = 8.0

    def step(self, scene):
        action = max(-1.0, min(1.0, 0.5 * (self._aim - scene.ego.speed)))
        return Decision(Command.from_action(action, change_lane=True), Trajectory.empty())


CASE = Drawn("S1", 6)


@pytest.fixture(scope="module")
def bound():
    return PulseSearch(CASE, Blind(), 30).run()


def test_what_it_found_reaches_the_goal_again(bound):
    assert bound.is_violation
    assert bound.is_repairable
    assert bound.collision.name in bound.text
    assert 0.0 < bound.lucky.dose <= bound.best.dose
    for profile in (bound.best, bound.lucky):
        summary = run_episode(CASE.scenario(), Blind(), PulsePlayer((profile.pulse,)))
        assert summary.outcome == EventKind.GOAL
        assert (summary.dose, summary.interventions) == (profile.dose, profile.frames)
        assert (summary.intensity, summary.digest) == (profile.intensity, profile.digest)
        assert profile.before_impact == pytest.approx(bound.impact - profile.pulse.start)


def test_the_best_does_not_hang_on_a_tenth_of_a_second(bound):
    pulse = bound.best.pulse
    for shift in (-2, 2):
        shifted = type(pulse)(max(0, pulse.begin + shift), pulse.ticks, pulse.action)
        assert run_episode(CASE.scenario(), Blind(), PulsePlayer((shifted,))).outcome == EventKind.GOAL


def test_a_budget_is_kept_and_buys_something(bound):
    short = PulseSearch(CASE, Blind(), 3).run()
    assert short.tries <= 5  # the neighbours of the last find are tried in any case
    assert bound.tries <= 32
    assert short.best is None or short.best.dose >= bound.best.dose


def test_it_goes_through_json(bound):
    assert Bound.parse(json.loads(json.dumps(bound.dump()))) == bound


def test_interrupted_work_goes_on(tmp_path, monkeypatch, bound):
    monkeypatch.setitem(POLICIES, "blind", PolicyEntry(NoParameters, lambda _parameters: Blind()))
    seen = []
    first = hindsight_bound([CASE], "blind", 1, tmp_path, seen.append, budget=30)
    assert first == seen == [bound]
    path = tmp_path / "hindsight-blind.jsonl"
    whole = path.read_bytes()
    path.write_bytes(whole + whole.splitlines(keepends=True)[1][:40])  # cut short in a second line

    def never(*_arguments):
        raise AssertionError

    monkeypatch.setattr(hindsight_file, "PulseSearch", never)
    assert hindsight_bound([CASE, CASE], "blind", 1, tmp_path, budget=30) == [bound, bound]
    assert path.read_bytes() == whole
    with pytest.raises(InputError, match="budget"):
        hindsight_bound([CASE], "blind", 1, tmp_path, budget=31)
    path.write_bytes(whole.replace(b'"family"', b'"genus"'))
    with pytest.raises(InputError, match="damaged"):
        hindsight_bound([CASE], "blind", 1, tmp_path, budget=30)
