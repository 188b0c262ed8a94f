"""Drives that are comfortable, and what makes them uncomfortable."""

import numpy as np
import pytest

from roadmend.measures.comfort import comfort, smoothers

TIMES = np.arange(0.0, 6.01, 0.05)


def drive(speed=lambda t: 10.0 + 0.0 * t, yaw_rate=lambda t: 0.0 * t, times=TIMES):
    return comfort(times, speed(times), yaw_rate(times))


def test_a_steady_drive_is_comfortable():
    assert drive() == 1.0
    assert drive(lambda t: 10.0 + 1.5 * t) == 1.0
    assert drive(yaw_rate=lambda t: 0.3 + 0.0 * t) == 1.0


@pytest.mark.parametrize(
    ("speed", "yaw_rate"),
    [
        (lambda t: 5.0 + 2.6 * t, lambda t: 0.0 * t),  # accelerates by more than 2.40 m/s2
        (lambda t: 30.0 - 4.3 * t, lambda t: 0.0 * t),  # brakes by more than 4.05 m/s2
        (lambda t: 20.0 + 0.0 * t, lambda t: 0.26 + 0.0 * t),  # 5.2 m/s2 to the side
        (lambda t: 3.0 + 0.0 * t, lambda t: 1.0 + 0.0 * t),  # turns by more than 0.95 rad/s
        (lambda t: 10.0 + 0.4 * np.sin(5.0 * t), lambda t: 0.0 * t),  # a longitudinal jerk of up to 10 m/s3
        (lambda t: 1.0 + 0.0 * t, lambda t: 0.8 * np.sin(4.0 * t)),  # yaw accelerates by up to 3.2 rad/s2
    ],
)
def test_each_bound_counts(speed, yaw_rate):
    assert drive(speed, yaw_rate) == 0.0


def test_only_the_pieces_with_the_jolt_are_lost():
    assert drive(lambda t: np.where(t < 5.0, 20.0, 20.0 - 6.0 * (t - 5.0))) == pytest.approx(2.0 / 3.0)


def test_gaps_and_another_rate_change_nothing_of_a_steady_change():
    gappy = np.delete(TIMES, [3, 4, 5, 40, 77])
    assert drive(lambda t: 10.0 + t, times=gappy) == drive(lambda t: 10.0 + t) == 1.0


def test_what_is_too_short_to_smooth_is_not_judged():
    assert drive(times=np.array([0.0])) is None
    assert drive(times=np.arange(0.0, 0.51, 0.05)) is None
    assert drive(times=np.arange(0.0, 1.01, 0.05)) == 1.0


def test_smoothing_leaves_a_parabola_as_it_is_and_gives_its_slope():
    times = 0.1 * np.arange(20)
    smooth, slope = smoothers(20)
    parabola = 3.0 - 2.0 * times + 5.0 * times**2
    assert smooth @ parabola == pytest.approx(parabola)
    assert slope @ parabola == pytest.approx(-2.0 + 10.0 * times)
