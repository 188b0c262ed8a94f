import numpy as np
import pytest

from roadmend.training.adreft.reliability import reliability


def test_who_says_what_is_seen_makes_no_error():
    scores = np.array([0.0, 0.25, 0.5, 1.0])
    found = reliability(scores, scores, np.ones(4))
    assert (found.moments, found.brier, found.calibration_error) == (4, 0.0, 0.0)
    assert found.rate == found.score == pytest.approx(0.4375)
    assert sum(each.weight for each in found.bins) == pytest.approx(1.0)


def test_by_hand():
    found = reliability(np.array([0.2, 0.22, 0.95]), np.array([0.0, 1.0, 1.0]), np.array([3.0, 1.0, 4.0]))
    assert [each.weight for each in found.bins] == pytest.approx([0.5, 0.5])
    assert [each.score for each in found.bins] == pytest.approx([0.205, 0.95])
    assert [each.seen for each in found.bins] == pytest.approx([0.25, 1.0])
    assert found.calibration_error == pytest.approx(0.5 * 0.045 + 0.5 * 0.05)
    assert found.brier == pytest.approx((3 * 0.04 + 0.78**2 + 4 * 0.05**2) / 8)
    assert found.brier_of_rate == pytest.approx(0.625 * 0.375)


def test_certainty_lies_in_the_last_bin_and_weights_need_no_scale():
    scores, seen = np.array([1.0, 0.999, 0.1]), np.array([1.0, 0.5, 0.0])
    found = reliability(scores, seen, np.full(3, 7.0))
    assert len(found.bins) == 2
    assert found == reliability(scores, seen, np.ones(3))
