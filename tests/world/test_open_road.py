"""An open road, and those who leave their lane or look out for nobody on it: seen in the figures of real SUMO."""

import math

import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.outcome import EventKind
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.scenario import Ego, Environment, ReportOrigin, Scenario
from roadmend.world.scenario_actors import Drift, Heedless, Trigger, Vehicle
from roadmend.world.scenario_networks import Arm, IntersectionNetwork, OpenRoadNetwork
from roadmend.world.simulation import Simulation

NOW = Trigger(time=0.0)


def film(scenario, command):
    """The actor's (x, y, yaw, speed) at every tick, and how the episode ended."""
    places = []
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        while tick.final is None:
            objects = tick.scene.objects
            if len(objects.x):
                places.append((objects.x[0], objects.y[0], objects.yaw[0], objects.speed[0]))
            tick = simulation.step(command)
    return np.array(places), tick.final


def road(*actors, **more):
    network = OpenRoadNetwork(**({"length": 400.0} | more))
    ego = Ego(route=["forward"], position=50.0, speed=10.0)
    far = Environment(sensing_range=1000.0)
    return Scenario(name="road", time_limit=20.0, network=network, ego=ego, actors=list(actors), environment=far)


@pytest.mark.parametrize("bend", [4.0, 8.0, 12.0, -20.0])
def test_the_middle_of_a_bend_lies_in_the_origin(bend):
    network = OpenRoadNetwork(lanes=1, backward_lanes=1, bend=bend, radius=400.0, length=300.0)
    forward = read_network(network_file(network)).edges["forward"].lanes[0].shape
    backward = read_network(network_file(network)).edges["backward"].lanes[0].shape
    ends = [0.5 * (forward[place] + backward[other]) for place, other in ((0, -1), (-1, 0))]
    assert abs(math.hypot(*ends[0]) - math.hypot(*ends[1])) < 0.1


@pytest.mark.parametrize("bend", [0.0, 60.0, -90.0])
def test_a_road_turns_by_its_bend_and_has_its_lanes(bend):
    network = OpenRoadNetwork(lanes=2, backward_lanes=3, bearing=90.0, bend=bend, radius=80.0, length=300.0)
    built = read_network(network_file(network))
    forward, backward = built.edges["forward"].car_lanes, built.edges["backward"].car_lanes
    assert (len(forward), len(backward)) == (2, 3)
    assert abs(forward[0].length - (300.0 + 80.0 * math.radians(abs(bend)))) < 12.0
    begin, end = np.diff(forward[0].shape[:2], axis=0)[0], np.diff(forward[0].shape[-2:], axis=0)[0]
    turned = math.degrees(math.atan2(begin[0] * end[1] - begin[1] * end[0], begin @ end))
    assert turned == pytest.approx(bend, abs=1.0)
    assert math.degrees(math.atan2(begin[1], begin[0])) == pytest.approx(90.0, abs=1.0)


def test_a_one_way_road_has_no_edge_backward():
    assert "backward" not in read_network(network_file(OpenRoadNetwork(backward_lanes=0))).edges


def test_who_drifts_across_the_centre_line_meets_the_ego_head_on():
    drift = Drift(when=Trigger(time=2.0), offset=3.2, over=1.5)
    actor = Vehicle(
        id="a", route=["backward"], position=150.0, speed=12.0, manoeuvres=[Heedless(when=NOW, speed=12.0), drift]
    )
    places, final = film(road(actor), Command(0.1, 0.0))
    assert final.kind is EventKind.COLLISION
    assert final.object_names == ("a",)
    before, after = places[30], places[-1]
    assert after[1] - before[1] == pytest.approx(-3.2, abs=0.3)  # it drives west: its left is south
    assert abs(math.degrees(math.remainder(after[2] - math.pi, math.tau))) < 12.0
    steps = np.hypot(*np.diff(places[75:, :2], axis=0).T)
    assert np.allclose(steps, 12.0 * 0.05, atol=0.1), "it keeps its speed"


def test_who_drifts_off_the_end_of_its_lane_is_gone():
    drift = Drift(when=NOW, offset=-4.0, over=1.0)
    actor = Vehicle(id="a", route=["forward"], position=330.0, speed=20.0, manoeuvres=[drift])
    with Simulation(road(actor)) as simulation:
        simulation.first()
        for _ in range(150):
            simulation.step(Command(0.0, 0.0))
        assert simulation.seen.names == ()


def test_who_is_heedless_runs_into_an_ego_that_stands_and_others_wait_for_it():
    def end_of(*manoeuvres):
        actor = Vehicle(id="a", route=["forward"], position=20.0, speed=10.0, manoeuvres=list(manoeuvres))
        return film(road(actor), Command(0.0, 1.0))[1]

    assert end_of(Heedless(when=NOW, speed=10.0)).kind is EventKind.COLLISION
    assert end_of().kind is EventKind.TIMEOUT


def test_an_arm_may_have_fewer_lanes_out_than_in():
    arms = [
        Arm(name=name, bearing=bearing, lanes=2, lanes_out=1) for name, bearing in (("a", 0), ("b", 90), ("c", 180))
    ]
    built = read_network(network_file(IntersectionNetwork(arms=arms)))
    assert (len(built.edges["a_in"].car_lanes), len(built.edges["a_out"].car_lanes)) == (2, 1)


def test_where_a_scenario_comes_from_changes_neither_its_digest_nor_files_without_it():
    plain = road()
    origin = ReportOrigin(report="r", vehicle=1, sampled={"lanes": 2})
    assert plain.model_copy(update={"origin": origin}).digest == plain.digest
    assert "origin" not in plain.model_dump()
    arm = Arm(name="a", bearing=0.0)
    assert "lanes_out" not in arm.model_dump()
