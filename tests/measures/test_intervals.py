import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.measures.intervals import bootstrap, by_group, newcombe, wilson


def test_wilson_and_newcombe_give_the_published_values():
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)  # Newcombe 1998, table I of the first paper
    assert newcombe(56, 70, 48, 80) == pytest.approx((0.0524, 0.3339), abs=1e-4)  # second paper, table II (a)
    assert newcombe(10, 10, 0, 10) == pytest.approx((0.6075, 1.0), abs=1e-4)  # (h)


@settings(deadline=None)
@given(st.integers(1, 60), st.integers(1, 60), st.data())
def test_an_interval_holds_its_difference(trials, others, data):
    count, other = data.draw(st.integers(0, trials)), data.draw(st.integers(0, others))
    low, high = newcombe(count, trials, other, others)
    assert -1.0 <= low <= count / trials - other / others <= high <= 1.0
    assert low < high  # even where everything was fixed and nothing degraded


def test_no_trials_are_no_share():
    with pytest.raises(ValueError, match="no trials"):
        wilson(0, 0)


def test_the_bootstrap_repeats_and_finds_the_standard_error_of_a_mean():
    table = np.random.default_rng(1).normal(3.0, 2.0, size=(400, 1))
    mean = lambda sums: sums[0][:, 0] / 400
    low, high = bootstrap((table,), mean)
    assert (low, high) == bootstrap((table,), mean)
    assert high - low == pytest.approx(2 * 1.96 * table.std() / 20.0, rel=0.1)
    assert low < table.mean() < high


def test_rows_of_a_group_are_drawn_together():
    rows = np.array([[1.0, 1.0], [0.0, 1.0]] * 50)
    mean = lambda sums: sums[0][:, 0] / sums[0][:, 1]
    alike = by_group(rows, [f"{'yes' if row[0] else 'no'} {place // 20}" for place, row in enumerate(rows)])
    assert alike.tolist() == [[10.0, 10.0], [0.0, 10.0]] * 5
    (low, high), (wide_low, wide_high) = bootstrap((rows,), mean), bootstrap((alike,), mean)
    assert wide_low < low < high < wide_high
    assert by_group(np.zeros((0, 2)), []).shape == (0, 2)


def test_the_bootstrap_of_what_is_never_defined_is_not_a_number():
    assert all(map(math.isnan, bootstrap((np.zeros((3, 1)),), lambda sums: sums[0][:, 0] * np.nan)))
