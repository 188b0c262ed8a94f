"""Outline geometry, held against an independent library."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.geometry import corner_distance, fill_corners, outline_distances, wrap_angle
from roadmend.core.scene import OBJECT, EgoState, ObjectList

coordinate = st.floats(-20.0, 20.0)
angle = st.floats(-math.pi, math.pi)
size = st.floats(0.3, 15.0)
outline = st.tuples(coordinate, coordinate, angle, size, size)


def corners_of(box):
    corners = np.empty((4, 2))
    fill_corners(corners, *box)
    return corners


@settings(max_examples=300, deadline=None)
@given(outline, outline)
def test_distance_equals_that_of_shapely(first, second):
    expected = shapely.Polygon(corners_of(first)).distance(shapely.Polygon(corners_of(second)))
    assert corner_distance(corners_of(first), corners_of(second)) == pytest.approx(expected, abs=1e-9)


def test_corners_go_counter_clockwise_from_front_left():
    assert corners_of((10.0, 5.0, 0.0, 4.0, 2.0)).tolist() == [[12, 6], [8, 6], [8, 4], [12, 4]]


def test_a_small_outline_inside_a_large_one_touches_it():
    assert corner_distance(corners_of((0, 0, 0.3, 10, 10)), corners_of((0.5, 0.2, 1.0, 1, 1))) == 0.0


def test_far_outlines_get_a_lower_bound_of_their_distance():
    own = EgoState.from_yaw(0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 2.0)
    place = {"x": 40.0, "y": 0.0, "yaw": 0.5, "length": 4.0, "width": 2.0}
    other = ObjectList(np.ones(1, dtype=OBJECT)).with_columns(**place).table
    bound, exact = outline_distances(own, other, 10.0)[0], outline_distances(own, other, 1000.0)[0]
    assert 10.0 <= bound <= exact


@pytest.mark.parametrize(
    ("given", "wrapped"), [(0.0, 0.0), (math.pi, math.pi), (-math.pi, math.pi), (3.5, 3.5 - 2 * math.pi)]
)
def test_wrap_angle(given, wrapped):
    assert wrap_angle(given) == pytest.approx(wrapped)
