"""Vehicles off the lanes move as bodies on tyres: their line is followed, the bounds are kept."""

import math

import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.tick import INTERVAL
from roadmend.world.scenario import Ego, Environment, Scenario
from roadmend.world.scenario_actors import Drift, Follow, Heedless, Trigger, Vehicle
from roadmend.world.scenario_networks import OpenRoadNetwork
from roadmend.world.simulation import Simulation
from roadmend.world.steering import SteeredBody

NOW = Trigger(time=0.0)


def film(*manoeuvres, speed=15.0, weather="clear", ticks=160):
    """Places and yaws of one vehicle on a straight road, tick by tick."""
    road = OpenRoadNetwork(lanes=1, backward_lanes=1, length=500.0)
    vehicle = Vehicle(
        id="v2", route=["forward"], position=150.0, speed=speed, speed_factor=2.0, manoeuvres=[*manoeuvres]
    )
    scenario = Scenario(
        name="s", network=road, ego=Ego(route=["forward"]), actors=[vehicle], environment=Environment(weather=weather)
    )
    rows = []
    with Simulation(scenario) as simulation:
        simulation.first()
        for _ in range(ticks):
            simulation.step(Command(0.0, 0.0))
            pose = simulation.everyone().get("v2")
            if pose is not None:
                rows.append((pose.x, pose.y, pose.yaw))
    return np.array(rows)


def hardest_sideways(rows):
    """The largest acceleration [m/s2], by a parabola through each half second."""
    slope = np.linalg.pinv(np.vander(np.arange(-5, 6) * INTERVAL, 3, increasing=True))[2]
    windows = np.lib.stride_tricks.sliding_window_view(rows[:, :2], 11, axis=0)
    return float(np.hypot(*(2.0 * windows @ slope).T).max())


@pytest.mark.parametrize("over", [0.3, 2.0])
@pytest.mark.parametrize("weather", ["clear", "snowy"])
def test_a_drift_arrives_beside_and_never_faster_than_tyres_can(over, weather):
    hold = Heedless(when=NOW, speed=15.0)
    rows = film(hold, Drift(when=Trigger(time=1.0), offset=3.2, over=over), weather=weather)
    assert rows[-1, 1] - rows[0, 1] == pytest.approx(3.2, abs=0.2)
    assert rows[-1, 2] == pytest.approx(0.0, abs=0.03)
    assert hardest_sideways(rows) < (0.5 * 9.81 if weather == "clear" else 0.35 * 9.81)
    assert np.abs(np.diff(rows[:, 0])).max() < 1.1 * 15.0 * INTERVAL, "no jump when it begins"


def test_a_second_drift_goes_on_from_where_the_first_one_led():
    drifts = [Drift(when=Trigger(time=time), offset=offset, over=2.0) for time, offset in ((0.5, 3.2), (4.0, -3.2))]
    rows = film(Heedless(when=NOW, speed=15.0), *drifts)
    assert rows[:, 1].max() - rows[0, 1] == pytest.approx(3.2, abs=0.3)
    assert rows[-1, 1] == pytest.approx(rows[0, 1], abs=0.3)
    assert hardest_sideways(rows) < 0.5 * 9.81


def test_a_line_of_its_own_is_followed_and_ends_in_a_stop():
    turn = [(-80.0 + 6.0 * math.sin(angle), 4.4 - 6.0 * math.cos(angle)) for angle in np.linspace(0.0, math.pi, 19)]
    line = [(-100.0, -1.6), *turn, (-120.0, 10.4)]
    rows = film(
        Heedless(when=NOW, speed=0.0), Follow(when=Trigger(time=0.5), points=line, speed=4.0), speed=0.0, ticks=520
    )
    assert abs(math.remainder(rows[-1, 2] - math.pi, math.tau)) < 0.2
    assert rows[-1, :2] == pytest.approx((-120.0, 10.4), abs=1.5)
    assert np.hypot(*(rows[-1, :2] - rows[-5, :2])) < 0.05
    assert hardest_sideways(rows) < 0.5 * 9.81


def test_backwards_the_rear_goes_first():
    back = Follow(when=Trigger(time=0.5), points=[(-103.0, -1.6), (-140.0, -1.6)], speed=3.0, backwards=True)
    rows = film(Heedless(when=NOW, speed=0.0), back, speed=0.0, ticks=200)
    assert rows[-1, 0] < rows[0, 0] - 15.0
    assert np.abs(rows[:, 2]).max() < 0.05
    assert rows[-1, 1] == pytest.approx(-1.6, abs=0.2)


def test_a_body_keeps_its_bounds_whatever_is_asked():
    body = SteeredBody(0.0, 0.0, 0.0, 20.0, 4.0)
    for _ in range(100):
        before = body.speed
        body.step(0.0, 1.0)
        assert before - body.speed <= 6.0 * INTERVAL + 1e-9
        assert body.speed**2 * abs(body.curvature) <= 4.0 + 1e-9 or body.speed < 1.0
        assert abs(body.curvature) <= 0.2
