import pytest

from roadmend.core.repair import Proposal
from roadmend.repair.latch import Latch

ON = Proposal(0.5, 0.0, -0.6, reason="hazard")
OFF = Proposal(-1.0, 0.0, 0.8)
TICK = 0.05


def actions(signal: str, hold: float = 0.3, clear: float = 0.1) -> str:
    """The answer to a string of ticks: x hazard or braking, . clear or free."""
    latch = Latch(hold, clear)
    answers = [latch.settle(tick * TICK, ON if letter == "x" else OFF) for tick, letter in enumerate(signal)]
    return "".join("x" if answer.score > answer.threshold else "." for answer in answers)


def test_one_tick_of_hazard_is_held_for_the_least_duration():
    assert actions("..x..........") == "..xxxxxx....."


def test_a_long_hazard_is_left_once_clear():
    assert actions("xxxxxxxxxx......") == "xxxxxxxxxxxx...."


def test_flicker_becomes_one_intervention():
    assert actions("x.x.x.x.x.x.x.x.") == "x" * 16


def test_without_hold_and_clear_nothing_is_held():
    assert actions("x.x..x", hold=0.0, clear=0.0) == "x.x..x"


@pytest.mark.parametrize("hold", [0.0, 0.1, 0.3, 1.0, 2.0])
@pytest.mark.parametrize("clear", [0.0, 0.1, 0.5])
def test_it_always_ends(hold, clear):
    ticks = round(max(hold, clear) / TICK) + 2
    assert actions("x" + "." * ticks, hold, clear)[-1] == "."


def test_the_held_action_is_the_last_one_and_says_so():
    latch = Latch(0.3, 0.1)
    latch.settle(0.0, ON)
    held = latch.settle(0.05, OFF)
    assert held.action == ON.action
    assert "held 0.05 s" in held.reason
    assert "hazard" in held.reason


def test_reset_forgets():
    latch = Latch(1.0, 1.0)
    latch.settle(0.0, ON)
    latch.reset()
    assert not latch.is_on
    assert latch.settle(0.05, OFF) is OFF
