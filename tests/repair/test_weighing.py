"""Weighing: values by hand, and what must hold of them for any adapter and any policy's action."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER, OUTPUTS, Weighing, weigh

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
    assert len({float(value) for value, action in zip(values, ACTIONS, strict=True) if action >= asked}) <= 1
