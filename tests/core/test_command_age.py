"""The time contract of the command path, at every rate, on a clock of the test's own."""

import pytest

from roadmend.core.command_age import LATE_TICKS, OBEYED_TICKS, PROMPT_S, CommandAge, age_of, is_obeyed
from roadmend.core.tick import INTERVAL_NS

RATES = (0.01, 0.5, 1.0, 1.3, 2.0, 5.0, 10.0, 100.0)


def late_at(contract, *, is_silent=False):
    """Ticks after which tick 0, whose command never comes, is declared late; looked at once a period."""
    now = 0.0
    while True:
        ticks = now / contract.tick
        if contract.is_late(now, int(ticks), is_silent=is_silent):
            return ticks
        now += contract.period
        assert ticks <= 10.0, "never"


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("timeout", [0.0, 0.02, 5.0])
def test_in_real_time_a_silent_policy_is_named_within_three_ticks_at_every_rate(rate, timeout):
    contract = CommandAge(is_lockstep=False, rate=rate, timeout=timeout)
    assert late_at(contract) < OBEYED_TICKS
    assert late_at(contract, is_silent=True) <= 1.0


@pytest.mark.parametrize("rate", RATES)
def test_the_repair_node_speaks_before_the_simulators_watchdog(rate):
    contract = CommandAge(is_lockstep=False, rate=rate)
    assert LATE_TICKS < OBEYED_TICKS
    assert is_obeyed(LATE_TICKS + 1)
    assert contract.silence < OBEYED_TICKS * contract.tick


@pytest.mark.parametrize("rate", RATES)
def test_the_next_tick_alone_is_neither_silence_nor_late(rate):
    contract = CommandAge(is_lockstep=False, rate=rate)
    assert contract.silence > 1.5 * contract.tick  # else what lies between two ticks would be a stop at low rates
    assert not contract.is_late(0.5 * contract.patience, 1, is_silent=False)
    assert contract.patience >= 0.79 * contract.tick
    assert contract.patience >= min(PROMPT_S, LATE_TICKS * contract.tick)


@pytest.mark.parametrize("rate", RATES)
def test_ticks_alone_make_late_whatever_the_wall_says(rate):
    contract = CommandAge(is_lockstep=False, rate=rate)
    assert contract.is_late(0.0, LATE_TICKS, is_silent=False)
    assert not contract.is_late(0.0, LATE_TICKS - 1, is_silent=False)


@pytest.mark.parametrize("rate", RATES)
def test_in_lockstep_only_the_wall_counts(rate):
    contract = CommandAge(is_lockstep=True, rate=rate)
    assert not contract.is_late(1.9, 100, is_silent=False)
    assert contract.is_late(2.0, 0, is_silent=False)
    assert not contract.is_late(0.01, 100, is_silent=True)
    assert contract.is_late(0.02, 0, is_silent=True)
    assert CommandAge(is_lockstep=True, timeout=7.0).patience == 7.0


def test_ages_are_whole_ticks_between_stamps():
    assert [age_of(stamp * INTERVAL_NS, 7 * INTERVAL_NS) for stamp in (8, 7, 4, 0)] == [-1, 0, 3, 7]
    assert [is_obeyed(age) for age in (-1, 0, 3, 4)] == [True, True, True, False]
