import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.core.errors import InputError
from roadmend.training.adreft.calibration import calibrate, calibrate_untouched, monitor_quality


@given(
    scores=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=60),
    recall=st.sampled_from([0.0, 0.5, 0.8, 0.95]),
    seed=st.integers(0, 1000),
)
def test_it_is_the_largest_threshold_with_enough_recall(scores, recall, seed):
    scores = np.array(scores)
    critical = np.random.default_rng(seed).random(len(scores)) < 0.5
    critical[0] = True
    threshold = calibrate(scores, critical, recall)
    count = critical.sum()
    assert (scores[critical] > threshold).sum() > recall * count - 1e-6
    higher = np.nextafter(threshold, np.inf)
    assert (scores[critical] > higher).sum() <= recall * count + 1e-6
    quality = monitor_quality(scores, critical, threshold)
    assert quality.recall > recall - 1e-6


def test_nineteen_of_twenty_are_not_more_than_95_per_cent():
    scores = np.arange(20) / 20.0
    assert calibrate(scores, np.ones(20, dtype=bool)) < 0.0
    scores = np.arange(40) / 40.0
    assert 0.0 <= calibrate(scores, np.ones(40, dtype=bool)) < scores[1]


def test_quality():
    scores = np.array([0.9, 0.8, 0.7, 0.6, 0.2, 0.1])
    critical = np.array([True, False, True, True, True, False])
    quality = monitor_quality(scores, critical, 0.5)
    assert (quality.precision, quality.recall) == (0.75, 0.75)
    assert quality.f1 == pytest.approx(0.75)
    assert monitor_quality(scores, critical, 0.95).f1 == 0.0
    assert monitor_quality(scores, ~critical & critical, 0.5).recall == 0.0


def test_without_a_critical_frame_there_is_no_threshold():
    with pytest.raises(InputError, match="no frame is critical"):
        calibrate(np.array([0.5]), np.array([False]))


@given(
    highest=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=60),
    touched=st.sampled_from([0.0, 0.1, 0.25, 0.9]),
)
def test_it_is_the_least_threshold_that_leaves_enough_drives_alone(highest, touched):
    highest = np.array(highest)
    threshold = calibrate_untouched(highest, touched)
    allowed = touched * len(highest) + 1e-6
    assert np.count_nonzero(highest > threshold) <= allowed
    assert np.count_nonzero(highest >= threshold) > allowed - 1e-5


def test_one_drive_in_ten_may_be_touched():
    assert calibrate_untouched(np.arange(20) / 20.0, 0.1) == 17 / 20
    assert calibrate_untouched(np.arange(20) / 20.0, 0.0) == 19 / 20
    assert calibrate_untouched(np.arange(9) / 9.0, 0.1) == 8 / 9


def test_without_a_harmless_drive_there_is_no_threshold():
    with pytest.raises(ValueError, match="no harmless drive"):
        calibrate_untouched(np.array([]), 0.1)
