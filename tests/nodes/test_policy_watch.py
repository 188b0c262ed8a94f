"""Who sends the policy's commands: who takes the place of another is given the time to tell of all its topics."""

import pytest

from roadmend.nodes.inputs import Input
from roadmend.nodes.policy_watch import SETTLE_S, PolicyWatch


@pytest.fixture
def watch(monkeypatch):
    """A watch, and those who publish the commands and what is wrong with them from now on."""
    there, faults = [], []
    monkeypatch.setattr(Input, "publishers", lambda *_: [*there])
    monkeypatch.setattr(Input, "heard", lambda *_: [*there])
    monkeypatch.setattr(Input, "faults", lambda *_: [*faults])
    return PolicyWatch(None, is_external=True), there, faults


def test_a_policy_has_settled_when_it_has_been_there_for_a_while(watch):
    made, there, _ = watch
    made.look(0.0)
    assert made.missing == ["nobody publishes it yet"]
    there.append("/one")
    made.look(1.0)
    assert made.missing == []
    assert not made.is_settled(1.0 + 0.9 * SETTLE_S)
    assert made.is_settled(1.0 + SETTLE_S)


def test_who_takes_the_place_of_another_between_two_looks_settles_anew(watch):
    made, there, _ = watch
    there.append("/one")
    made.look(0.0)
    there[:] = ["/two"]
    made.look(SETTLE_S)
    assert not made.is_settled(SETTLE_S)
    made.look(1.5 * SETTLE_S)
    assert made.is_settled(2.0 * SETTLE_S)


def test_who_could_not_be_heard_settles_from_when_it_can(watch):
    made, there, faults = watch
    there.append("/one")
    made.look(0.0)
    faults.append("/one offers an incompatible QoS")
    made.look(1.0)
    assert made.missing == faults
    faults.clear()
    made.look(5.0)
    assert not made.is_settled(5.0)
