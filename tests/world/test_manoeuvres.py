"""Scripted misbehaviour is what it says: seen in the figures of real SUMO."""

import math

import libsumo
import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.tick import INTERVAL
from roadmend.world.manoeuvres import _SPEED_MODE_HEEDLESS
from roadmend.world.scenario import Ego, Environment, Scenario
from roadmend.world.scenario_actors import Brake, CutIn, Heedless, RunRightOfWay, Trigger, Vehicle
from roadmend.world.scenario_networks import Arm, HighwayExitNetwork, IntersectionNetwork, OpenRoadNetwork
from roadmend.world.simulation import Simulation

LANE_WIDTH = 3.2  # [m]
NOW = Trigger(time=1.0)
ROLL = Command(0.05, 0.0)
FAR = Environment(sensing_range=1000.0)


def highway(actor, *, ego_lane=1, ego_position=150.0, time_limit=12.0):
    """Three lanes at 25 m/s; the ego in the middle one."""
    network = HighwayExitNetwork(lanes=3, speed_limit=25.0, approach_length=600.0)
    ego = Ego(route=["approach", "diverge", "mainline"], lane=ego_lane, position=ego_position, speed=22.0)
    return Scenario(name="test", time_limit=time_limit, network=network, ego=ego, actors=[actor], environment=FAR)


def actor_in(lane, *manoeuvres, ahead=30.0, speed=22.0, **more):
    given = {"route": ["approach", "diverge", "mainline"], "lane": lane, "position": 150.0 + ahead, "speed": speed}
    return Vehicle(id="actor", manoeuvres=list(manoeuvres), **(given | {"speed_factor": 0.9} | more))


def crossing(control, *actors, time_limit=14.0, **more):
    """Four arms; the ego far away in the south. East and west are the main road where there is one."""
    arms = [
        Arm(name=name, bearing=bearing, length=150.0, major=name in ("east", "west"))
        for name, bearing in (("south", -90.0), ("east", 0.0), ("north", 90.0), ("west", 180.0))
    ]
    network = IntersectionNetwork(arms=arms, control=control, **more)
    ego = Ego(route=["south_in", "north_out"], position=5.0)
    return Scenario(name="test", time_limit=time_limit, network=network, ego=ego, actors=list(actors), environment=FAR)


def film(scenario, command=ROLL, watch=lambda: None):
    """Every tick of a scenario driven on one command: time, ego, and the actor of each name (x, y, yaw, speed)."""
    seen = []
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        while tick.final is None:
            numbers = {simulation._participants.number_of(name): name for name in simulation._participants._names}
            objects = tick.scene.objects
            actors = {
                numbers[int(number)]: (objects.x[index], objects.y[index], objects.yaw[index], objects.speed[index])
                for index, number in enumerate(objects.id)
                if int(number) in numbers
            }
            seen.append((tick.scene.time, tick.scene.ego, actors, watch()))
            tick = simulation.step(command)
    return seen


def of_actor(seen, column, name="actor"):
    """(time, value) of one actor as two arrays."""
    rows = [(time, actors[name][column]) for time, _, actors, _ in seen if name in actors]
    return np.array(rows).T


@pytest.mark.parametrize(("lane", "direction"), [(2, "ego"), (0, "ego"), (2, "right"), (0, "left")])
def test_a_cut_in_is_in_the_egos_lane_within_four_seconds(lane, direction):
    seen = film(highway(actor_in(lane, CutIn(when=NOW, direction=direction))))
    time, y = of_actor(seen, 1)
    ego_y = seen[0][1].y
    offset = np.abs(y - ego_y)
    assert offset[time <= 1.0] == pytest.approx(LANE_WIDTH, abs=0.1)
    assert offset[time <= 5.0][-1] < 0.8
    assert offset[time <= 7.0][-1] < 0.1


@pytest.mark.parametrize("ahead", [12.0, 18.0, 26.0])
def test_a_cut_in_does_not_care_how_close_the_ego_is(ahead):
    seen = film(highway(actor_in(2, CutIn(when=NOW, direction="ego"), ahead=ahead)), Command(0.15, 0.0))
    time, y = of_actor(seen, 1)
    assert abs(y[time <= 5.0][-1] - seen[0][1].y) < 0.8


@pytest.mark.parametrize(("lane", "direction"), [(1, "ego"), (2, "left"), (0, "right")])
def test_where_there_is_no_lane_to_cut_into_nothing_happens(lane, direction):
    seen = film(highway(actor_in(lane, CutIn(when=NOW, direction=direction))))
    time, y = of_actor(seen, 1)
    assert np.ptp(y[time <= 6.0]) < 0.3


@pytest.mark.parametrize(("deceleration", "speed"), [(3.0, 4.0), (4.0, 1.0), pytest.param(8.0, 0.0)])
def test_braking_reaches_its_speed_at_about_its_deceleration_holds_it_and_drives_on(deceleration, speed):
    brake = Brake(when=NOW, speed=speed, deceleration=deceleration, hold=2.0)
    seen = film(highway(actor_in(2, brake), time_limit=16.0))
    time, value = of_actor(seen, 3)
    before = value[time <= 1.0][-1]
    slow = time[value <= speed + 0.1]
    duration = (before - speed) / deceleration
    assert slow[0] - 1.0 == pytest.approx(duration, rel=0.15, abs=0.15)
    steady = (time > 1.0 + 0.1 * duration) & (time < 1.0 + 0.9 * duration)
    assert -np.gradient(value[steady], INTERVAL).mean() == pytest.approx(deceleration, rel=0.1)
    assert slow[-1] - slow[0] == pytest.approx(2.0, abs=0.5)
    assert value[-1] > speed + 3.0


def test_a_manoeuvre_by_distance_begins_when_the_ego_comes_near_from_behind():
    near = Trigger(ego_distance=20.0)
    brake = Brake(when=near, speed=5.0, deceleration=5.0, hold=1.0)
    seen = film(highway(actor_in(2, brake, ahead=45.0, speed=12.0, speed_factor=0.5), time_limit=8.0))
    first = next(
        (time, math.hypot(actors["actor"][0] - ego.x, actors["actor"][1] - ego.y))
        for time, ego, actors, _ in seen
        if "actor" in actors and actors["actor"][3] < 11.0
    )
    assert first[0] > 1.0
    assert 12.0 < first[1] <= 20.0


def test_a_manoeuvre_by_distance_does_not_begin_behind_the_ego():
    near = Trigger(ego_distance=20.0)
    brake = Brake(when=near, speed=0.0, deceleration=8.0, hold=3.0)
    seen = film(
        highway(actor_in(2, brake, ahead=-15.0, speed=20.0, speed_factor=0.8), time_limit=4.0), Command(0.5, 0.0)
    )
    _, value = of_actor(seen, 3)
    assert value.min() > 15.0


def test_each_manoeuvre_happens_once_and_two_may_overlap():
    swoop = [CutIn(when=NOW, direction="ego"), Brake(when=NOW, speed=8.0, deceleration=4.0, hold=1.0)]
    seen = film(highway(actor_in(2, *swoop, ahead=60.0), time_limit=14.0), Command(0.0, 0.3))
    time, value = of_actor(seen, 3)
    _, y = of_actor(seen, 1)
    assert value.min() == pytest.approx(8.0, abs=0.3)
    assert abs(y[time <= 5.0][-1] - seen[0][1].y) < 0.8
    assert value[-1] > 15.0


def vehicle(name, way, *manoeuvres, position=70.0, **more):
    begin, end = way.split()
    given = {"route": [f"{begin}_in", f"{end}_out"], "position": position, "speed": 12.0, "speed_factor": 0.9}
    return Vehicle(id=name, manoeuvres=list(manoeuvres), **(given | more))


def test_running_means_through_a_red_light_at_speed():
    """From two arms that are never green together: one driver stops, unless they run."""

    def slowest(*manoeuvres):
        actors = [vehicle("east", "east west", *manoeuvres), vehicle("south", "north south", *manoeuvres)]
        # One at a time, so that they do not brake for each other.
        return {
            actor.id: of_actor(film(crossing("traffic_light", actor, time_limit=9.0), Command(0.0, 1.0)), 3, actor.id)[
                1
            ].min()
            for actor in actors
        }

    lawful = slowest()
    stopped = [name for name, speed in lawful.items() if speed < 1.0]
    assert len(stopped) == 1
    hasty = slowest(RunRightOfWay(when=Trigger(time=0.1), hold=15.0))
    assert hasty[stopped[0]] > 8.0


def test_running_means_yielding_to_nobody():
    main_road = [vehicle(f"m{number}", "east west", position=5.0 + 22.0 * number) for number in range(6)]

    def slowest(*manoeuvres):
        runner = vehicle("runner", "north south", *manoeuvres, position=75.0)
        seen = film(crossing("priority", *main_road, runner, time_limit=8.0), Command(0.0, 1.0))
        return of_actor(seen, 3, "runner")[1].min()

    assert slowest() < 2.0
    assert slowest(RunRightOfWay(when=Trigger(time=0.1), hold=15.0)) > 2.0


def test_haste_is_over_when_the_manoeuvre_is():
    run = RunRightOfWay(when=NOW, haste=1.5, hold=3.0)
    factors = film(
        highway(actor_in(2, run, speed_factor=0.8), time_limit=7.0),
        watch=lambda: libsumo.vehicle.getSpeedFactor("actor"),
    )
    of_time = {round(time, 2): factor for time, _, _, factor in factors}
    assert of_time[0.5] == pytest.approx(0.8)
    assert of_time[2.0] == pytest.approx(1.2)
    assert of_time[6.0] == pytest.approx(0.8)


@pytest.mark.parametrize(
    "earlier",
    [
        Brake(when=NOW, speed=8.0, deceleration=4.0, hold=2.0),
        RunRightOfWay(when=NOW, haste=1.2, hold=3.0),
        CutIn(when=NOW, direction="right"),
    ],
    ids=lambda manoeuvre: manoeuvre.action,
)
def test_heedless_lasts_whatever_was_under_way_before(earlier):
    heedless = Heedless(when=Trigger(time=2.0), speed=15.0)
    seen = film(
        highway(actor_in(2, earlier, heedless), ego_position=20.0, time_limit=12.0),
        Command(0.0, 0.0),
        lambda: libsumo.vehicle.getSpeedMode("actor"),
    )
    time, value = of_actor(seen, 3)
    assert value[time > 7.0] == pytest.approx(15.0, abs=0.1)
    assert {mode for time, *_, mode in seen if time > 2.1} == {_SPEED_MODE_HEEDLESS}
    _, y = of_actor(seen, 1)
    assert (abs(y[-1] - y[0]) > 2.5) == isinstance(earlier, CutIn)


def test_the_end_of_one_braking_does_not_end_another():
    first = Brake(when=Trigger(time=1.0), speed=4.0, deceleration=6.0, hold=2.0)
    second = Brake(when=Trigger(time=3.0), speed=2.0, deceleration=7.0, hold=4.0)
    braking = []
    scenario = highway(actor_in(2, first, second, ahead=120.0), ego_position=20.0, time_limit=16.0)
    seen = film(scenario, Command(0.0, 1.0), lambda: braking.append(libsumo.vehicle.getDecel("actor")))
    time, speed = of_actor(seen, 3)
    assert speed[(time > 5.5) & (time < 8.0)] == pytest.approx(2.0, abs=0.1)
    assert speed[-1] > 6.0
    assert (braking[0], max(braking), braking[-1]) == (braking[-1], 7.0, braking[0])


def test_who_has_waited_for_a_standing_ego_goes_on_braking_as_told():
    brake = Brake(when=Trigger(time=0.1), speed=0.5, deceleration=6.0, hold=30.0)
    actor = Vehicle(id="actor", route=("forward",), position=93.0, speed=1.5, manoeuvres=(brake,))
    ego = Ego(route=("forward",), position=100.0, speed=0.0)
    scenario = Scenario(
        name="s", network=OpenRoadNetwork(length=600.0), ego=ego, actors=(actor,), time_limit=20.0, environment=FAR
    )
    waited, speeds = False, []
    with Simulation(scenario) as simulation:
        simulation.first()
        for step in range(300):
            simulation.step(Command(0.0, 1.0) if step < 120 else Command(0.6, 0.0))
            waited = waited or "actor" in simulation._courtesy.waiting
            speeds.append(libsumo.vehicle.getSpeed("actor"))
    assert waited
    assert max(speeds[150:]) == pytest.approx(0.5, abs=0.01)


def test_an_actor_that_leaves_in_the_middle_of_its_manoeuvre_is_no_fault():
    run = RunRightOfWay(when=Trigger(time=0.1), hold=60.0)
    leaver = vehicle("leaver", "east west", run, position=100.0)
    seen = film(crossing("priority", leaver, time_limit=30.0), Command(0.0, 1.0))
    assert "leaver" in seen[0][2]
    assert "leaver" not in seen[-1][2]
