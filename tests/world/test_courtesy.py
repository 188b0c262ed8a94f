"""Nobody drives into a car that stands before them, and nobody waits longer than it stands."""

import math

import libsumo
import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.outcome import EventKind
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.world.courtesy import STANDING, Courtesy
from roadmend.world.scenario import Ego, Environment, Scenario
from roadmend.world.scenario_actors import RunRightOfWay, Trigger, Vehicle
from roadmend.world.scenario_networks import Arm, IntersectionNetwork, OpenRoadNetwork
from roadmend.world.simulation import Simulation

STANDS = EgoState.from_yaw(0.0, 0.0, 0.0, 0.0, 0.0, 4.7, 1.85)
DRIVES = STANDS._replace(speed=STANDING)


class Drivers:
    """What SUMO is told about speeds: -1 lets a driver go."""

    def __init__(self):
        self.orders = {}
        self.braking = {}  # [m/s^2]

    def __call__(self, name, speed):
        self.orders[name] = speed


@pytest.fixture
def drivers(monkeypatch):
    told = Drivers()
    monkeypatch.setattr(libsumo.vehicle, "setSpeed", told)
    monkeypatch.setattr(libsumo.vehicle, "getDecel", lambda name: told.braking.get(name, 4.5))
    monkeypatch.setattr(libsumo.vehicle, "setDecel", told.braking.__setitem__)
    monkeypatch.setattr(libsumo.vehicle, "getSpeedFactor", lambda _: 1.0)
    monkeypatch.setattr(libsumo.vehicle, "setSpeedFactor", lambda *_: None)
    return told


def others(*rows, kind=ObjectKind.CAR):
    """Rows of x, y, yaw, speed, yaw rate."""
    x, y, yaw, speed, turn = np.array(rows, dtype=np.float64).reshape(-1, 5).T.copy()
    return ObjectList.of(
        id=np.arange(1, len(x) + 1),
        kind=kind,
        x=x,
        y=y,
        yaw=yaw,
        speed=speed,
        acceleration=0.0,
        yaw_rate=turn,
        length=4.5,
        width=1.8,
    )


AIMED = (0.0, -6.0, 0.5 * math.pi, 2.0, 0.0)  # from the side, straight at it


@pytest.mark.parametrize(
    ("row", "waits"),
    [
        (AIMED, True),
        ((0.0, -5.0, 0.5 * math.pi, 0.0, 0.0), True),  # stands and wants to start
        ((-7.0, 0.0, 0.0, 2.0, 0.0), True),  # from behind
        ((7.0, 0.3, math.pi, 2.0, 0.0), True),  # from ahead
        ((-6.0, 2.6, 0.0, 4.0, 0.0), False),  # passes beside it
        ((0.0, -6.0, -0.5 * math.pi, 2.0, 0.0), False),  # drives away
        ((0.0, -3.5, -0.5 * math.pi, 0.5, 0.0), False),  # drives away from close by
        ((0.0, -13.0, 0.5 * math.pi, 2.0, 0.0), False),  # still far
        ((0.0, -40.0, 0.5 * math.pi, 30.0, 0.0), False),  # not looked at
    ],
)
def test_who_would_touch_a_standing_ego_waits(drivers, row, waits):
    Courtesy().step(STANDS, ("other",), others(row))
    assert drivers.orders == ({"other": 0.0} if waits else {})


def test_a_bend_counts(drivers):
    straight = (-6.0, 3.2, 0.0, 3.0, 0.0)
    Courtesy().step(STANDS, ("other",), others(straight))
    assert drivers.orders == {}
    Courtesy().step(STANDS, ("other",), others((*straight[:4], -0.7)))
    assert drivers.orders == {"other": 0.0}


def test_people_on_foot_find_their_own_way(drivers):
    Courtesy().step(STANDS, ("person",), others(AIMED, kind=ObjectKind.PEDESTRIAN))
    assert drivers.orders == {}


def test_nobody_waits_for_an_ego_that_drives(drivers):
    Courtesy().step(DRIVES, ("other",), others(AIMED))
    assert drivers.orders == {}


def test_who_waits_may_go_when_the_ego_drives(drivers):
    courtesy = Courtesy()
    courtesy.step(STANDS, ("a", "b"), others(AIMED, (7.0, 0.3, math.pi, 2.0, 0.0)))
    assert drivers.orders == {"a": 0.0, "b": 0.0}
    courtesy.step(DRIVES, ("a", "b"), others(AIMED, (7.0, 0.3, math.pi, 2.0, 0.0)))
    assert drivers.orders == {"a": -1.0, "b": -1.0}


def test_who_waits_may_brake_hard_and_only_then(drivers):
    courtesy = Courtesy()
    courtesy.step(STANDS, ("a",), others(AIMED))
    assert drivers.braking["a"] > 7.0
    assert [*courtesy.waiting] == ["a"]
    courtesy.step(DRIVES, ("a",), others(AIMED))
    assert drivers.braking["a"] == 4.5
    assert not courtesy.waiting


def test_who_was_in_a_manoeuvre_goes_on_with_it(drivers):
    courtesy = Courtesy()
    both = others(AIMED, (7.0, 0.3, math.pi, 2.0, 0.0))
    courtesy.step(STANDS, ("a", "b"), both)
    assert courtesy.resume("a", 6.0)
    assert not courtesy.resume("c", 6.0)
    courtesy.step(DRIVES, ("a", "b"), both, held={"a": 0.5})
    assert drivers.orders == {"a": 0.5, "b": -1.0}
    assert drivers.braking == {"a": 6.0, "b": 4.5}


def test_in_sumo_who_has_waited_is_the_driver_that_it_was():
    """Another one than the type's, as in traffic of a user's own."""
    behind = Vehicle(id="behind", route=("forward",), position=92.0, speed=1.0)
    ego = Ego(route=("forward",), position=100.0, speed=0.0)
    scenario = Scenario(name="s", network=OpenRoadNetwork(length=600.0), ego=ego, actors=(behind,), time_limit=20.0)
    with Simulation(scenario) as simulation:
        simulation.first()
        libsumo.vehicle.setSpeedFactor("behind", 1.25)
        waited = False
        for step in range(300):
            simulation.step(Command(0.0, 1.0) if step < 150 else Command(0.6, 0.0))
            waited = waited or "behind" in simulation._courtesy.waiting
            assert libsumo.vehicle.getSpeedFactor("behind") == 1.25
    assert waited


def test_who_has_a_free_way_again_may_go_and_the_others_wait_on(drivers):
    courtesy = Courtesy()
    courtesy.step(STANDS, ("a", "b"), others(AIMED, (7.0, 0.3, math.pi, 2.0, 0.0)))
    drivers.orders.clear()
    courtesy.step(STANDS, ("a", "b"), others(AIMED, (7.0, 4.0, math.pi, 2.0, 0.0)))
    assert drivers.orders == {"b": -1.0}


def test_a_driver_is_told_once(drivers):
    courtesy = Courtesy()
    courtesy.step(STANDS, ("a",), others(AIMED))
    drivers.orders.clear()
    courtesy.step(STANDS, ("a",), others(AIMED))
    assert drivers.orders == {}


def test_a_driver_who_has_left_is_told_nothing(drivers):
    courtesy = Courtesy()
    courtesy.step(STANDS, ("a",), others(AIMED))
    drivers.orders.clear()
    courtesy.step(STANDS, (), others())
    courtesy.step(DRIVES, (), others())
    assert drivers.orders == {}


def test_in_sumo_a_driver_before_a_standing_ego_waits_and_goes_on_when_it_has_gone():
    """The ego stops inside the junction, across the way of somebody who gives way to nobody."""
    arms = [
        Arm(name=name, bearing=bearing, length=100.0, major=name in ("south", "north"))
        for name, bearing in (("south", -90.0), ("east", 0.0), ("north", 90.0), ("west", 180.0))
    ]
    runner = Vehicle(
        id="runner",
        route=["west_in", "east_out"],
        position=30.0,
        speed=8.0,
        speed_factor=0.7,
        manoeuvres=[RunRightOfWay(when=Trigger(time=0.1), hold=60.0)],
    )
    scenario = Scenario(
        name="test",
        time_limit=40.0,
        network=IntersectionNetwork(arms=arms),
        actors=[runner],
        ego=Ego(route=["south_in", "north_out"], position=80.0, speed=5.0, goal=60.0),
        environment=Environment(sensing_range=500.0),
    )
    stood, places, passed = 0, [], False
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        while tick.final is None:
            ego = tick.scene.ego
            if passed or ego.y < -3.0:
                command = Command(0.3 if ego.speed < 5.0 else 0.0, 0.0)
            else:
                command = Command(0.0, 1.0)
                stood += ego.speed < STANDING
                passed = stood >= 200
            if len(tick.scene.objects):
                places.append((stood, float(tick.scene.objects.x[0]), float(tick.scene.objects.speed[0])))
            tick = simulation.step(command)
    assert tick.final.kind is EventKind.GOAL
    waited = [(x, speed) for count, x, speed in places if 150 <= count < 200]
    assert all(speed < 0.1 for _, speed in waited)
    assert all(-12.0 < x < -2.5 for x, _ in waited)  # before the ego, not in it
    assert max(x for _, x, _ in places) > 5.0  # and on it went
