"""Student's t against the tables."""

import math
import statistics

import pytest

from roadmend.measures.paired_test import mean_interval, paired_p_value


@pytest.mark.parametrize(
    ("freedom", "t"),
    [(1, 12.706), (2, 4.3027), (3, 3.1824), (4, 2.7764), (5, 2.5706), (9, 2.2622), (30, 2.0423)],
)
def test_the_critical_values_of_the_tables(freedom, t):
    values = [float(value) for value in range(freedom + 1)]
    low, high = mean_interval(values)
    error = statistics.stdev(values) / math.sqrt(len(values))
    assert (high - low) / (2.0 * error) == pytest.approx(t, rel=1e-4)
    # Two samples whose differences have just this t are apart at 5 %.
    mean = statistics.fmean(values)
    assert paired_p_value([value - mean + t * error for value in values], [0.0] * len(values)) == pytest.approx(
        0.05, abs=1e-5
    )


def test_paired_differences():
    # Differences 1, 2, 3, 2, 2: mean 2, standard deviation sqrt(0.5), t = 6.3246 with 4 degrees of freedom.
    assert paired_p_value([2.0, 4.0, 6.0, 6.0, 7.0], [1.0, 2.0, 3.0, 4.0, 5.0]) == pytest.approx(0.0032, abs=1e-4)
    assert paired_p_value([1.0, 2.0], [1.0, 2.0]) is None
    assert paired_p_value([1.0], [0.0]) is None
    with pytest.raises(ValueError, match="argument"):
        paired_p_value([1.0, 2.0], [1.0])


def test_the_interval_of_a_mean():
    low, high = mean_interval([1.0, 2.0, 3.0, 2.0, 2.0])
    assert (low, high) == (pytest.approx(2.0 - 0.8780, abs=1e-3), pytest.approx(2.0 + 0.8780, abs=1e-3))
    assert mean_interval([1.0]) is None
    assert mean_interval([2.0, 2.0]) == (2.0, 2.0)
