"""The way of a participant out of a recording."""

import numpy as np
import pytest

from roadmend.sera.track import track_of

from .recorded import TICK_NS, ego, episode, track


def test_a_way_is_cut_out_of_the_recording():
    way = track(np.arange(10.0), 3.0, 0.0, 20.0)
    made = episode([ego()] * 10, [track(50.0, 0.0, 0.0, np.zeros(10)), way])
    found = track_of(made, 8, 2 * TICK_NS, 5 * TICK_NS)
    assert found.x.tolist() == [2.0, 3.0, 4.0, 5.0]
    assert (found.id, found.kind, found.length) == (8, 1, 4.0)
    assert track_of(made, 9, 0, 9 * TICK_NS) is None


def test_between_neighbouring_sights_and_after_the_last_one_its_place_is_known():
    way = track([0.0, 1.0, 2.0], 0.0, 0.5 * np.pi, 20.0)
    assert way.pose(TICK_NS) == (1.0, 0.0, pytest.approx(0.5 * np.pi))
    assert way.pose(4 * TICK_NS)[:2] == pytest.approx((2.0, 2.0))
    assert way.pose(TICK_NS + 1) is None
    assert way.pose(-1) is None
