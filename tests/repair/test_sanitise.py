import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.core.command import Command, Trajectory
from roadmend.repair.sanitise import is_usable_ego, is_usable_plan, mark_usable, sanitise_command, usable_plan

from .playground import Box, ego_at, object_list

PEDALS = [-math.inf, -2.0, -1.0, -0.5, -0.0, 0.0, 0.3, 1.0, 1.0 + 1e-12, 2.0, math.inf, math.nan]


@pytest.mark.parametrize(
    ("throttle", "brake", "expected"),
    [
        (math.nan, 0.0, -0.5),
        (math.nan, 0.7, -0.7),
        (math.nan, math.inf, -1.0),
        (math.nan, math.nan, -0.5),
        (math.inf, 0.0, -0.5),
        (-math.inf, 0.0, -0.5),
        (0.8, math.nan, -0.5),
        (0.0, math.inf, -1.0),
        (0.9, math.inf, -1.0),
        (0.6, -math.inf, 0.6),
        (1.7, 0.0, 1.0),
        (-0.4, 0.0, -0.4),
        (-0.4, 0.6, -0.6),
        (-4.0, 0.0, -1.0),
        (0.0, 1.3, -1.0),
        (0.5, -0.2, 0.5),
        (0.9, 0.1, -0.1),
    ],
)
def test_toward_braking(throttle, brake, expected):
    assert sanitise_command(Command(throttle, brake), 0.5).action == expected


def test_every_pair_of_pedals_becomes_a_valid_command_that_accelerates_no_more():
    for throttle in PEDALS:
        for brake in PEDALS:
            asked = Command(throttle, brake, change_lane=True)
            given_back = sanitise_command(asked, 0.5)
            assert given_back.fault == ""
            if math.isfinite(throttle) and math.isfinite(brake):
                assert given_back.action <= max(0.0, min(1.0, throttle))
                assert given_back.brake >= min(1.0, max(0.0, brake))
            if not asked.fault:
                assert given_back == asked


@given(st.floats(), st.floats(), st.floats(0.1, 1.0))
def test_any_floats_become_a_valid_command(throttle, brake, stop):
    assert sanitise_command(Command(throttle, brake), stop).fault == ""


def test_no_lane_change_on_pedals_that_are_no_numbers():
    assert not sanitise_command(Command(math.nan, 0.0, change_lane=True), 0.5).change_lane
    assert sanitise_command(Command(0.5, 0.5, change_lane=True), 0.5).change_lane


@pytest.mark.parametrize("field", ["x", "y", "speed", "yaw_rate", "length", "width", "yaw"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_odometry_must_be_finite(field, bad):
    assert is_usable_ego(ego_at(), 0.0)
    assert not is_usable_ego(ego_at()._replace(**{field: bad}), 0.0)
    assert not is_usable_ego(ego_at(), bad)


@pytest.mark.parametrize(("field", "bad"), [("length", 0.0), ("width", -1.0), ("x", 1e9), ("y", -1e9)])
def test_odometry_must_make_sense(field, bad):
    assert not is_usable_ego(ego_at()._replace(**{field: bad}), 0.0)


@pytest.mark.parametrize(("field", "limit"), [("x", 1e8), ("x", -1e8), ("y", 1e8), ("y", -1e8)])
def test_the_ego_is_less_than_100_000_km_away(field, limit):
    assert is_usable_ego(ego_at()._replace(**{field: 0.999 * limit}), 0.0)
    assert not is_usable_ego(ego_at()._replace(**{field: limit}), 0.0)


@pytest.mark.parametrize("field", ["length", "width"])
def test_the_ego_may_be_small_but_has_a_size(field):
    assert is_usable_ego(ego_at()._replace(**{field: 0.01}), 0.0)
    assert not is_usable_ego(ego_at()._replace(**{field: 0.0}), 0.0)


def usable(objects) -> tuple[int, list[bool]]:
    keep = np.zeros(max(64, len(objects)), dtype=np.bool_)
    dropped = mark_usable(keep, objects.table, 60.0, 10.0, 150.0)
    return dropped, keep[: len(objects)].tolist()


@pytest.mark.parametrize("field", ["x", "y", "yaw", "speed", "acceleration", "yaw_rate", "length", "width"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_an_object_with_a_field_that_is_not_finite_is_dropped_alone(field, bad):
    boxes = [Box(1, 0.0, 0.0), replace(Box(2, 5.0, 0.0), **{field: bad}), Box(3, 9.0, 0.0)]
    assert usable(object_list(boxes)) == (1, [True, False, True])


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        ("length", 0.0),
        ("length", -4.0),
        ("length", 60.1),
        ("width", 0.0),
        ("width", -1.0),
        ("width", 10.1),
        ("speed", 151.0),
        ("speed", -151.0),
        ("x", 1e9),
    ],
)
def test_an_object_out_of_all_reason_is_dropped_alone(field, bad):
    boxes = [Box(1, 0.0, 0.0), replace(Box(2, 5.0, 0.0), **{field: bad})]
    assert usable(object_list(boxes)) == (1, [True, False])


@pytest.mark.parametrize(
    ("field", "good"), [("length", 60.0), ("length", 0.01), ("width", 10.0), ("width", 0.4), ("speed", 150.0)]
)
def test_the_bounds_themselves_are_usable(field, good):
    assert usable(object_list([replace(Box(2, 5.0, 0.0), **{field: good})])) == (0, [True])


@pytest.mark.parametrize(
    ("field", "limit"),
    [("x", 1e8), ("y", 1e8), ("yaw", 1e4), ("acceleration", 1e4), ("yaw_rate", 1e4)],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_up_to_the_limits_of_all_reason_an_object_is_usable(field, limit, sign):
    assert usable(object_list([replace(Box(2, 5.0, 0.0), **{field: 0.999 * sign * limit})])) == (0, [True])
    assert usable(object_list([replace(Box(2, 5.0, 0.0), **{field: sign * limit})])) == (1, [False])


@pytest.mark.parametrize("count", [0, 1, 8, 9, 16, 17, 33, 64])
def test_no_id_is_taken_for_another(count):
    """Neither those of a real list nor those that fall on one place of the table, nor the largest."""
    for ids in (range(count), range(0, 16 * count, 16), range(2**32 - count, 2**32)):
        assert usable(object_list([Box(number, 0.0, 0.0) for number in ids])) == (0, [True] * count)
        twice = [Box(number, 0.0, 0.0) for number in ids] * 2
        assert usable(object_list(twice)) == (count, [True] * count + [False] * count)


def test_of_equal_ids_the_first_usable_one_stays():
    boxes = [Box(7, math.nan, 0.0), Box(7, 1.0, 0.0), Box(8, 2.0, 0.0), Box(7, 3.0, 0.0), Box(7, 4.0, 0.0)]
    assert usable(object_list(boxes)) == (3, [False, True, True, False, False])


def test_duplicates_are_found_in_a_long_list_whose_ids_collide():
    ids = [65536 * index for index in range(500)] * 2
    dropped, keep = usable(object_list([Box(number, float(index), 0.0) for index, number in enumerate(ids)]))
    assert dropped == 500
    assert keep == [True] * 500 + [False] * 500


@pytest.mark.parametrize("interval", [0.0, -0.1, 1e-20, 0.999e-3, math.nan, math.inf])
def test_a_plan_needs_an_interval_that_can_be_counted(interval):
    points = np.ones(3)
    assert is_usable_plan(0.1, points, points, points, points)
    assert not is_usable_plan(interval, points, points, points, points)


@pytest.mark.parametrize("column", range(4))
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_plan_must_be_finite_and_even(column, bad):
    arrays = [np.ones(3) for _ in range(4)]
    arrays[column][1] = bad
    assert not is_usable_plan(0.1, *arrays)
    arrays[column] = np.ones(2)
    assert not is_usable_plan(0.1, *arrays)


@pytest.mark.parametrize("column", range(4))
def test_up_to_the_limits_of_all_reason_a_plan_is_usable(column):
    limit = (1e8, 1e8, 1e4, 1e4)[column]
    for sign in (1.0, -1.0):
        for share, expected in ((0.999, True), (1.0, False)):
            for point in range(3):
                arrays = [np.ones(3) for _ in range(4)]
                arrays[column][point] = share * sign * limit
                assert is_usable_plan(0.1, *arrays) is expected


@pytest.mark.parametrize("interval", [1e-3, 0.5, 100.0])
def test_any_interval_from_a_millisecond_on_will_do(interval):
    points = np.ones(3)
    assert is_usable_plan(interval, points, points, points, points)


def test_a_plan_has_up_to_600_points():
    assert is_usable_plan(0.1, *[np.ones(600)] * 4)
    assert not is_usable_plan(0.1, *[np.ones(601)] * 4)


@pytest.mark.parametrize("count", [0, 1, 4])
def test_a_plan_reaches_less_than_a_million_seconds_ahead(count):
    points, interval = np.ones(count), 1e6 / max(count, 1)
    assert is_usable_plan(0.999 * interval, points, points, points, points)
    assert not is_usable_plan(interval, points, points, points, points)


def test_in_place_of_an_unusable_plan_there_is_one_without_points():
    points = np.ones(3)
    plan = Trajectory(0.1, points, points, points, points, "follow")
    assert usable_plan(plan) is plan
    assert len(usable_plan(replace(plan, yaw=np.empty(0)))) == 0
    assert len(usable_plan(replace(plan, interval=math.nan))) == 0


def test_a_plan_without_points_is_usable():
    none = np.empty(0)
    assert is_usable_plan(1.0, none, none, none, none)


@pytest.mark.parametrize("stop", [0.125, 0.5, 1.0])
def test_without_a_number_the_stop_or_the_harder_brake_that_was_asked_for(stop):
    for brake in (0.0, 0.3, 0.7, 1.0, 3.0):
        expected = Command(0.0, max(stop, min(1.0, brake)))
        for throttle in (math.nan, math.inf, -math.inf):
            assert sanitise_command(Command(throttle, brake, change_lane=True), stop) == expected
    for throttle in (-0.5, 0.0, 0.4, 1.0):
        assert sanitise_command(Command(throttle, math.nan, change_lane=True), stop) == Command(0.0, stop)


@pytest.mark.parametrize("change_lane", [False, True])
@pytest.mark.parametrize(
    ("throttle", "brake", "expected"),
    [(-0.4, 0.0, -0.4), (-0.4, 0.3, -0.4), (-0.4, 0.6, -0.6), (-1.2, 0.5, -1.0), (0.7, 0.2, -0.2), (1.5, -0.3, 1.0)],
)
def test_a_wish_that_is_a_number_keeps_its_lane_change(throttle, brake, expected, change_lane):
    found = sanitise_command(Command(throttle, brake, change_lane), 0.5)
    assert found == Command.from_action(expected, change_lane=change_lane)
