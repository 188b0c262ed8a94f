"""Weighing: values by hand, and what must hold of them for any adapter and any policy's action."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.weighing import (
    AVERTED,
    CAUSED,
    DANGER,
    MILDEST,
    OUTPUTS,
    Weighing,
    gain_of,
    weigh,
)

PRICES = Weighing(collision=10.0, strength=0.4, exponent=2.0, any=0.1)


def logit(chance):
    return np.log(chance / (1.0 - chance))


def foreseen(danger, averted, caused):
    outputs = np.empty(OUTPUTS, dtype=np.float32)
    outputs[DANGER], outputs[AVERTED], outputs[CAUSED] = logit(danger), logit(averted), logit(caused)
    return outputs


def test_values_by_hand():
    values = weigh(foreseen(0.5, 0.75, 0.1), 0.4, PRICES)
    # 0.8, 0.6 and 0.4 change nothing; with 0.0 a collision comes in 0.5 * 0.25 + 0.5 * 0.1 of all cases.
    np.testing.assert_allclose(values[:3], -5.0, atol=1e-5)
    assert values[4] == pytest.approx(-1.75 - 0.4 * 0.4**2 - 0.1, abs=1e-5)
    assert values[9] == pytest.approx(-1.75 - 0.4 * 1.4**2 - 0.1, abs=1e-5)
    assert ACTIONS[int(values.argmax())] == 0.2  # of what averts as much, the gentlest


def test_where_nothing_threatens_the_policy_is_left_alone():
    assert int(weigh(foreseen(0.001, 0.9, 0.001), 0.5, PRICES).argmax()) == 0


def test_what_no_trial_has_held_is_never_chosen_for_its_promises():
    outputs = foreseen(0.5, 0.1, 0.1)
    outputs[AVERTED.start] = logit(0.99)  # 0.8 where the policy asks for 1: nothing has taught the adapter of it
    values = weigh(outputs, 1.0, PRICES)
    assert values[0] == pytest.approx(-5.0, abs=1e-5)


def test_gain_by_hand():
    # 0.2 costs 0.4 * 0.2**2 + 0.1 and leaves a collision in 0.5 * 0.25 + 0.5 * 0.1 of all cases, the policy in half.
    assert gain_of(weigh(foreseen(0.5, 0.75, 0.1), 0.4, PRICES), 0.4) == pytest.approx(5.0 - 1.75 - 0.116, abs=1e-5)
    assert gain_of(weigh(foreseen(0.5, 0.75, 0.1), 1.0, PRICES), 1.0) == pytest.approx(5.0 - 1.75 - 0.164, abs=1e-5)
    assert gain_of(weigh(foreseen(0.001, 0.75, 0.001), 0.4, PRICES), 0.4) == 0.0


def test_the_gain_of_a_choice_that_is_not_the_best_may_be_a_loss():
    values = weigh(foreseen(0.5, 0.75, 0.1), 0.4, PRICES)
    best = int(values.argmax())
    assert gain_of(values, 0.4, best) == gain_of(values, 0.4) > 0.0
    assert gain_of(values, 0.4, 9) == pytest.approx(5.0 - 1.75 - 0.4 * 1.4**2 - 0.1, abs=1e-5)
    assert gain_of(values, 0.4, 2) == 0.0  # brakes no harder than the policy
    calm = weigh(foreseen(0.001, 0.75, 0.001), 0.4, PRICES)
    assert gain_of(calm, 0.4, 9) < -0.8


def test_what_is_not_finite_stays_so():
    outputs = foreseen(0.5, 0.5, 0.5)
    outputs[3] = np.nan
    assert np.isnan(weigh(outputs, 0.5, PRICES)).all()


@given(
    st.lists(st.floats(-1e6, 1e6, width=32), min_size=OUTPUTS, max_size=OUTPUTS),
    st.floats(-1.0, 1.0),
)
def test_values_are_finite_prices_and_idle_actions_are_worth_the_same(outputs, asked):
    values = weigh(np.array(outputs, dtype=np.float32), asked, PRICES)
    assert values.dtype == np.float32
    assert np.isfinite(values).all()
    assert (values <= 0.0).all()
    idle = {float(values[place]) for place, action in enumerate(ACTIONS) if action >= asked or place < MILDEST}
    assert len(idle) == 1
    assert gain_of(values, asked) == pytest.approx(float(values.max()) - idle.pop(), rel=1e-5)
