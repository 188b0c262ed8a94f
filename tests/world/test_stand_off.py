"""Who blocks the ego inside a junction for too long is taken off the road, and nobody else is."""

import math

import libsumo
import pytest

from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.world.stand_off import PATIENCE, StandOff

INTERVAL = 0.5  # [s]
TICKS = round(PATIENCE / INTERVAL)
ACROSS, BESIDE, FAR = (6.0, 0.0), (6.0, 4.0), (30.0, 0.0)


@pytest.fixture
def sumo(monkeypatch):
    """Stands in for the three calls that are made: lane, place on it, removal."""
    removed = []
    lanes = {"inside": ":centre_1_0", "queue": "south_in_0", "leaving": "south_out_0"}
    monkeypatch.setattr(libsumo.vehicle, "getLaneID", lambda name: lanes[name])
    monkeypatch.setattr(libsumo.vehicle, "getLanePosition", lambda name: 3.0 if name == "leaving" else 40.0)
    monkeypatch.setattr(libsumo.vehicle, "getLength", lambda _name: 10.0)
    monkeypatch.setattr(libsumo.vehicle, "remove", removed.append)
    return removed


def ego(x=0.0):
    return EgoState.from_yaw(x, 0.0, 0.0, 0.0, 0.0, 4.7, 1.85)


def one(place, speed=0.0, kind=ObjectKind.BUS, yaw=0.5 * math.pi):
    return ObjectList.of(
        id=[1],
        kind=kind,
        x=place[0],
        y=place[1],
        yaw=yaw,
        speed=speed,
        acceleration=0.0,
        yaw_rate=0.0,
        length=4.5,
        width=1.8,
    )


def run(ticks, name="inside", place=ACROSS, *, speed=0.0, pace=0.0, kind=ObjectKind.BUS, waiting=(), yaw=0.5 * math.pi):
    """Ticks until somebody is removed, or None."""
    stand_off = StandOff(INTERVAL)
    for tick in range(ticks):
        x = pace * INTERVAL * tick
        found = stand_off.step(
            ego(x),
            lambda ahead, x=x: (x + ahead, 0.0, 0.0),
            (name,),
            one((x + place[0], place[1]), speed, kind, yaw),
            waiting,
        )
        if found:
            assert found == [name]
            return tick
    return None


def test_after_a_while_it_is_gone_and_not_before(sumo):
    assert run(3 * TICKS) == TICKS
    assert sumo == ["inside"]


def test_who_has_left_the_junction_but_for_its_rear_counts(sumo):
    assert run(3 * TICKS, "leaving") == TICKS


def test_who_waits_for_the_ego_need_not_be_in_its_way(sumo):
    assert run(3 * TICKS, place=BESIDE) is None
    assert run(3 * TICKS, place=BESIDE, waiting=("inside",)) == TICKS


def test_who_queues_behind_the_ego_stays_however_long_it_waits(sumo):
    assert run(3 * TICKS, place=(-8.0, 0.2), waiting=("inside",), yaw=0.1) is None
    assert sumo == []


@pytest.mark.parametrize("place", [(-8.0, 3.0), (8.0, 0.0)])
def test_who_waits_in_another_place_is_no_queue(sumo, place):
    assert run(3 * TICKS, place=place, waiting=("inside",), yaw=0.1) == TICKS


@pytest.mark.parametrize(
    "case",
    [
        {"name": "queue"},
        {"place": BESIDE},
        {"place": FAR},
        {"speed": 2.0},
        {"pace": 1.0},
        {"kind": ObjectKind.PEDESTRIAN},
    ],
)
def test_nobody_else_is_removed(sumo, case):
    assert run(3 * TICKS, **case) is None
    assert sumo == []


def test_the_clock_starts_again_when_the_ego_gets_on(sumo):
    stand_off = StandOff(INTERVAL)
    found = []
    for tick in range(2 * TICKS - 2):
        x = 0.0 if tick < TICKS - 1 else 3.0
        found += stand_off.step(ego(x), lambda ahead, x=x: (x + ahead, 0.0, 0.0), ("inside",), one((x + 6.0, 0.0)), ())
    assert found == []
