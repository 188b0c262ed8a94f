import math

import numpy as np
import pytest

from roadmend.core import portable_math

ANGLES = np.linspace(-7.0, 7.0, 24).reshape(4, 6)


@pytest.mark.parametrize("name", ["sin", "cos", "exp"])
def test_values_are_the_c_librarys_in_the_shape_that_was_given(name):
    found = getattr(portable_math, name)(ANGLES)
    assert found.shape == ANGLES.shape
    assert found.tolist() == [[getattr(math, name)(angle) for angle in row] for row in ANGLES]


def test_two_coordinates_give_an_angle_and_a_base_a_power():
    assert portable_math.atan2(np.sin(ANGLES), np.cos(ANGLES)) == pytest.approx(np.angle(np.exp(1j * ANGLES)))
    assert portable_math.power(np.array([0.0, 0.5, 3.0]), 2.0).tolist() == [0.0, 0.25, 9.0]


def test_what_is_not_a_number_stays_so_and_nothing_stays_nothing():
    assert np.isnan(portable_math.exp(np.array([math.nan]))).all()
    assert portable_math.sin(np.empty((0, 2))).shape == (0, 2)
    with pytest.raises(OverflowError):
        portable_math.exp(np.array([1000.0]))
