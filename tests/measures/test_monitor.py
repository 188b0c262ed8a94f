import numpy as np
import pytest

from roadmend.measures.monitor import Confusion, separation_of, summarise_monitor


def test_frames_are_counted_and_pooled():
    labels = np.array([True, True, True, False, False, False])
    first = Confusion.of(labels, np.array([True, True, False, True, False, False]))
    assert first == Confusion(hits=2, false_alarms=1, misses=1, quiet=2)
    second = Confusion.of(~labels, np.zeros(6, dtype=np.bool_))
    figures = summarise_monitor([first, second], ["one", "other"])
    assert (figures["frames"], figures["critical_frames"]) == (12, 6)
    assert figures["precision"] == pytest.approx(100.0 * 2 / 3)
    assert figures["recall"] == pytest.approx(100.0 * 2 / 6)
    assert figures["f1"] == pytest.approx(100.0 * 4 / (4 + 1 + 4))


def test_labels_and_alarms_must_be_of_the_same_frames():
    with pytest.raises(ValueError, match="3 labels for 2 frames"):
        Confusion.of(np.zeros(3, dtype=np.bool_), np.zeros(2, dtype=np.bool_))


def test_a_monitor_that_never_speaks_has_no_precision():
    figures = summarise_monitor([Confusion(0, 0, 5, 10)], ["one"])
    assert figures["precision"] is None
    assert (figures["recall"], figures["f1"]) == (0.0, 0.0)
    assert figures["intervals"]["precision"] is None


def test_intervals_draw_searches():
    episodes = [Confusion(8, 2, 1, 9), Confusion(8, 2, 1, 9), Confusion(1, 5, 9, 5), Confusion(1, 5, 9, 5)]
    apart, kin, one = (summarise_monitor(episodes, groups) for groups in ("abcd", "aabb", "aaaa"))
    assert apart["f1"] == kin["f1"] == one["f1"]
    (low, high), (kin_low, kin_high) = apart["intervals"]["f1"], kin["intervals"]["f1"]
    assert kin_low <= low
    assert high <= kin_high
    assert one["intervals"]["f1"] is None


def test_separation_counts_pairs_and_ties_half():
    scores, critical = np.array([0.1, 0.2, 0.3, 0.4, 0.9, 0.3]), np.array([0, 0, 0, 0, 1, 1], dtype=bool)
    assert separation_of(scores, critical) == pytest.approx((4 + 2.5) / 8)
    assert separation_of(scores, ~critical) == pytest.approx(1.5 / 8)
    assert separation_of(scores, np.zeros(6, bool)) is None
    assert separation_of(scores, np.ones(6, bool)) is None
