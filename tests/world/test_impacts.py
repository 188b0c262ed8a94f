"""What stands beside a road or on it: who leaves the lanes strikes it, the ego sees it and can strike it, too."""

import math

import pytest

from roadmend.core.command import Command
from roadmend.core.outcome import EventKind
from roadmend.core.scene import ObjectKind
from roadmend.world.impacts import pose_of
from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario import Ego, Environment, Scenario
from roadmend.world.scenario_actors import Follow, Trigger, Vehicle
from roadmend.world.scenario_networks import OpenRoadNetwork
from roadmend.world.simulation import Simulation

ROAD = OpenRoadNetwork(lanes=1, backward_lanes=1, length=400.0)
STANDING = Ego(route=["forward"], position=20.0)
LANE = -1.6  # [m] y of the lane's middle
OFF = Follow(when=Trigger(time=0.0), points=[(-60.0, LANE), (-20.0, LANE), (40.0, -9.0), (90.0, -15.0)], speed=15.0)


def tree(x=20.0, y=-6.6, **changes):
    return Obstacle(id="tree", kind="tree", x=x, y=y, **changes)


def scenario(*obstacles, ego=STANDING, line=OFF):
    vehicle = Vehicle(id="v1", route=["forward"], position=150.0, speed=15.0, speed_factor=2.0, manoeuvres=[line])
    return Scenario(name="s", network=ROAD, ego=ego, actors=[vehicle], obstacles=[*obstacles])


def places(what, ticks=120):
    """Where the vehicle is [m], and its speed [m/s], tick by tick."""
    with Simulation(what) as simulation:
        simulation.first()
        rows = []
        for _ in range(ticks):
            simulation.step(Command(0.0, 0.0))
            rows.append(simulation.everyone())
    return [(each["v1"].x, each["v1"].y, each["v1"].speed) for each in rows], rows[-1]


def test_who_strikes_something_firm_stands_there_from_then_on():
    rows, last = places(scenario(tree()))
    moving = [row for row in rows if row[2] > 1.0]
    assert moving[-1][2] == pytest.approx(15.0, abs=0.5)
    assert rows[-1][:2] == rows[len(moving) + 1][:2]
    assert abs(rows[-1][0] + 2.3 - 20.0) < 1.2
    assert last["tree"] == pose_of(tree())


def test_what_is_not_firm_stops_nobody_and_what_is_beside_the_way_neither():
    for one in (tree(firm=False), tree(y=-20.0)):
        rows, last = places(scenario(one))
        assert rows[-1][0] > 30.0
        assert "tree" in last


def test_the_ego_sees_it_and_strikes_it():
    what = scenario(tree(x=-120.0, y=LANE), ego=Ego(route=["forward"], position=20.0, speed=20.0))
    with Simulation(what) as simulation:
        tick = simulation.first()
        kinds = dict(zip(tick.scene.objects.id, tick.scene.objects.kind, strict=True))
        assert ObjectKind.UNKNOWN in kinds.values()
        while tick.final is None:
            tick = simulation.step(Command(0.3, 0.0))
    assert tick.final.kind is EventKind.COLLISION
    assert "tree" in str(tick.final)


@pytest.mark.parametrize("length", [4.0, 100.0])
def test_a_long_one_is_seen_and_struck_where_it_begins_however_near_one_sees(length):
    def drive(sight):
        wall = tree(x=-100.0 + 0.5 * length, y=LANE, length=length)
        what = scenario(wall, ego=Ego(route=["forward"], position=20.0, speed=20.0))
        seen = None
        with Simulation(what.model_copy(update={"environment": Environment(sensing_range=sight)})) as simulation:
            tick = simulation.first()
            while tick.final is None:
                if seen is None and ObjectKind.UNKNOWN in tick.scene.objects.kind:
                    seen = tick.scene.ego.x
                tick = simulation.step(Command(0.1, 0.0))
        return seen, tick

    found = {sight: drive(sight) for sight in (20.0, 39.0, 60.0, 150.0)}
    assert len({tick.number for _, tick in found.values()}) == 1
    assert all(tick.final.object_names == ("tree",) for _, tick in found.values())
    assert all(-100.0 - seen == pytest.approx(min(sight, 80.0), abs=2.0) for sight, (seen, _) in found.items())
    assert found[20.0][1].scene.ego.x + 0.5 * 4.7 == pytest.approx(-100.0, abs=1.2)


def test_an_ego_that_stands_before_it_waits_as_long_as_it_wants():
    what = scenario(tree(x=-174.5, y=LANE), ego=Ego(route=["forward"], position=20.0))
    with Simulation(what) as simulation:
        tick = simulation.first()
        for _ in range(220):
            tick = simulation.step(Command(0.0, 1.0))
        assert tick.final is None
        assert tick.min_distance == pytest.approx(2.9, abs=0.3)


def test_its_pose_is_in_the_map_frame():
    pose = pose_of(tree(heading=90.0, length=4.0, width=1.0))
    assert (pose.yaw, pose.length, pose.width, pose.speed) == (pytest.approx(0.5 * math.pi), 4.0, 1.0, 0.0)


def test_names_are_given_once():
    with pytest.raises(ValueError, match="obstacle id 'tree' is used twice"):
        scenario(tree(), tree())
