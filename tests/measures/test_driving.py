"""The four measures of hand-made drives."""

import numpy as np
import pytest

from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.route import RightOfWay, Route, Stage, Zone
from roadmend.core.scene import EgoState, ObjectKind, ObjectList, Scene, Signal
from roadmend.measures.driving import MeasuresObserver

STAGE = Stage(np.array([0.0, 200.0]), np.zeros(2), np.full(2, 14.0))
ZONE = Zone(0, 50.0, 70.0, RightOfWay.SIGNAL, 0)
GOAL = Event(10.0, EventKind.GOAL, "there")


def objects(kind=ObjectKind.CAR, speed=8.0):
    return ObjectList.of(
        id=[7],
        kind=kind,
        x=120.0,
        y=9.0,
        yaw=0.0,
        speed=speed,
        acceleration=0.0,
        yaw_rate=0.0,
        length=4.0,
        width=2.0,
    )


def driven(to, speed=10.0, around=None, signal=Signal.GREEN, zones=(ZONE,), begin=0.0):
    """An observer that has seen a drive at a constant speed from ``begin`` to ``to`` [m]."""
    observer = MeasuresObserver(Route("straight", 4.0, 2.0, 100.0, 60.0, (STAGE,), (), zones))
    for number in range(round((to - begin) / speed * 20) + 1):
        ego = EgoState.from_yaw(begin + number * speed / 20, 0.0, 0.0, speed, 0.0, 4.0, 2.0)
        seen = objects() if around is None else around
        observer.see(Scene(number / 20, ego, seen, np.array([signal], dtype=np.uint8)))
    return observer


def test_a_drive_to_the_goal_is_a_success():
    found = driven(100.0).measures(GOAL)
    assert (found.driving_score, found.route_completion, found.success, found.infractions) == (100.0, 100.0, True, ())
    assert found.efficiency == pytest.approx(125.0)
    assert found.comfortness == 100.0
    assert not found.at_fault


@pytest.mark.parametrize(
    ("kind", "blame", "factor", "at_fault"),
    [
        (ObjectKind.CAR, Blame.FRONT, 0.6, True),
        (ObjectKind.BICYCLE, Blame.FRONT, 0.6, True),
        (ObjectKind.PEDESTRIAN, Blame.FRONT, 0.5, True),
        (ObjectKind.CAR, Blame.REAR, 0.6, False),
        (ObjectKind.CAR, Blame.EGO_STOOD, 1.0, False),
    ],
)
def test_a_collision_costs_the_rest_of_the_way_and_a_factor_by_whom_it_met(kind, blame, factor, at_fault):
    found = driven(40.0, around=objects(kind)).measures(
        Event(4.0, EventKind.COLLISION, "bang", (7,), ("x",), (kind,), blame, 9.0)
    )
    assert found.route_completion == pytest.approx(40.0)
    assert found.driving_score == pytest.approx(40.0 * factor)
    assert (found.success, found.at_fault) == (False, at_fault)


def test_a_time_out_costs_what_is_left_of_the_way_and_no_more():
    found = driven(30.0).measures(Event(9.0, EventKind.TIMEOUT, "late"))
    assert (found.driving_score, found.infractions, found.success) == (pytest.approx(30.0), (), False)


def test_a_red_light_is_an_infraction_once_and_no_success():
    found = driven(100.0, signal=Signal.RED).measures(GOAL)
    assert (found.infractions, found.driving_score, found.success) == (("red_light",), pytest.approx(70.0), False)


@pytest.mark.parametrize(("signal", "begin"), [(Signal.GREEN, 0.0), (Signal.YELLOW, 0.0), (Signal.RED, 60.0)])
def test_other_lights_and_one_that_turns_red_behind_the_stop_line_are_none(signal, begin):
    assert driven(100.0, signal=signal, begin=begin).measures(GOAL).infractions == ()


def test_a_stop_line_without_a_light_is_none():
    zone = Zone(0, 50.0, 70.0, RightOfWay.STOP, -1)
    assert driven(100.0, signal=Signal.RED, zones=(zone,)).measures(GOAL).infractions == ()


@pytest.mark.parametrize(
    ("around", "expected"),
    [
        (objects(speed=20.0), 50.0),
        (objects(speed=0.0), None),  # the traffic stands
        (objects(speed=0.5), None),  # 2000 %: as good as standing
        (objects(ObjectKind.PEDESTRIAN), None),
        (ObjectList.empty(), None),
    ],
)
def test_efficiency_is_the_speed_against_that_of_vehicles_that_move(around, expected):
    assert driven(100.0, around=around).measures(GOAL).efficiency == (
        None if expected is None else pytest.approx(expected)
    )


def test_efficiency_weighs_stretches_of_the_way_alike_however_long_they_take():
    observer = MeasuresObserver(Route("straight", 4.0, 2.0, 100.0, 60.0, (STAGE,), (), ()))
    for number in range(201):  # 25 m at half the others' speed, then as fast as they
        fast = number > 100
        ego = EgoState.from_yaw(
            0.25 * number if not fast else 25.0 + 0.75 * (number - 100), 0, 0, 8.0 if fast else 4.0, 0, 4, 2
        )
        observer.see(Scene(number / 20, ego, objects(), np.zeros(0, dtype=np.uint8)))
    assert observer.measures(GOAL).efficiency == pytest.approx(87.5, abs=1.5)


def test_an_episode_of_one_tick_is_measured():
    found = driven(0.0).measures(Event(0.0, EventKind.COLLISION, "bang", (7,), ("x",), (), Blame.FRONT, 9.0))
    assert (found.route_completion, found.driving_score, found.comfortness) == (0.0, 0.0, None)
