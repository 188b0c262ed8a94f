"""A SUMO configuration of the user's own: its network, its traffic, and not one file left beside it."""

import math
import shutil

import libsumo
import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.core.scene import ObjectKind
from roadmend.world.network import network_file
from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario import Ego, Environment, Scenario
from roadmend.world.scenario_actors import Vehicle
from roadmend.world.scenario_file import parse_scenario
from roadmend.world.scenario_networks import Arm, IntersectionNetwork, SumoConfiguration
from roadmend.world.simulation import Simulation
from roadmend.world.user_configuration import private_copy

CONFIGURATION = """<configuration>
    <input>
        <net-file value="town.net.xml"/>
        <route-files value="demand.rou.xml"/>
        <additional-files value="detectors/loops.add.xml, near.add.xml"/>
    </input>
    <output><fcd-output value="fcd.xml"/><tripinfo-output value="trips.xml"/></output>
    <report><log value="town.log"/></report>
    <time><begin value="100"/><end value="4000"/></time>
</configuration>"""
DEMAND = """<routes>
    <vType id="slow" maxSpeed="9"/>
    <flow id="ew" type="slow" begin="100" end="4000" period="9" from="east_in" to="west_out"/>
    <flow id="ns" type="slow" begin="100" end="4000" period="7" from="north_in" to="south_out"/>
    <person id="walker" depart="100"><walk from="north_in" to="east_out"/></person>
</routes>"""
LOOP = '<additional><e1Detector id="{name}" lane="east_in_1" pos="50" freq="10" file="{file}"/></additional>'


@pytest.fixture
def town(tmp_path):
    """A configuration with detectors that write, beside it and in a folder below."""
    arms = [
        Arm(name=name, bearing=bearing, length=120.0, major=name in ("east", "west"))
        for name, bearing in (("south", -90.0), ("east", 0.0), ("north", 90.0), ("west", 180.0))
    ]
    folder = tmp_path / "a town" / "of mine"
    (folder / "detectors").mkdir(parents=True)
    shutil.copy(network_file(IntersectionNetwork(arms=arms, crossings=True)), folder / "town.net.xml")
    (folder / "town.sumocfg").write_text(CONFIGURATION)
    (folder / "demand.rou.xml").write_text(DEMAND)
    (folder / "near.add.xml").write_text(LOOP.format(name="near", file="near.xml"))
    (folder / "detectors" / "loops.add.xml").write_text(LOOP.format(name="far", file="far.xml"))
    return folder / "town.sumocfg"


def scenario_on(town, *route, warm_up=30.0, time_limit=3.0, **ego):
    network = SumoConfiguration(path=str(town), warm_up=warm_up)
    return Scenario(name="town", time_limit=time_limit, network=network, ego=Ego(route=list(route), **ego))


def contents(folder):
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


def drive(scenario, watch=lambda _simulation, _tick: None):
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        while tick.final is None:
            watch(simulation, tick)
            tick = simulation.step(Command(0.2 if tick.scene.ego.speed < 5.0 else 0.0, 0.0))
        return simulation, tick


@pytest.mark.parametrize("route", [("south_in", "north_out"), ()])
def test_it_runs_on_an_own_route_or_one_of_the_traffic_and_leaves_no_file(town, tmp_path, route, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = contents(tmp_path)
    simulation, tick = drive(scenario_on(town, *route))
    assert tick.final.kind is EventKind.TIMEOUT
    assert contents(tmp_path) == before
    chosen = simulation.scenario.ego.route
    assert tuple(chosen) == route if route else chosen in (["east_in", "west_out"], ["north_in", "south_out"])


def test_the_object_list_holds_everybody(town):
    seen = []

    def watch(simulation, tick):
        everybody = {*libsumo.vehicle.getIDList(), *libsumo.person.getIDList()} - {"ego"}
        listed = {name for name in everybody if simulation._participants.number_of(name) in set(tick.scene.objects.id)}
        assert listed == everybody
        assert len(tick.scene.objects) == len(everybody)
        seen.append(everybody)

    drive(scenario_on(town, "south_in", "north_out"), watch)
    assert max(map(len, seen)) >= 5
    assert any("walker" in everybody for everybody in seen)


ALIKE = """<routes>
    <vehicle id="0" depart="100" departLane="1" departPos="80"><route edges="south_in north_out"/>
        <stop lane="south_in_1" endPos="85" until="9999"/></vehicle>
    <person id="0" depart="100"><walk from="north_in" to="east_out"/></person>
</routes>"""


def test_a_vehicle_a_person_and_an_obstacle_of_one_name_are_three(town):
    (town.parent / "demand.rou.xml").write_text(ALIKE)
    scenario = scenario_on(town, "south_in", "north_out", time_limit=20.0)
    everybody = []

    def watch(simulation, tick):
        objects = tick.scene.objects
        everybody.append({(int(number), int(kind)) for number, kind in zip(objects.id, objects.kind, strict=True)})
        assert simulation.everyone().keys() == {"0", "obstacle 0"}

    obstacle = Obstacle(id="0", x=30.0, y=30.0)
    simulation, tick = drive(scenario.model_copy(update={"obstacles": [obstacle]}), watch)
    kinds = (ObjectKind.CAR, ObjectKind.PEDESTRIAN, ObjectKind.UNKNOWN)
    assert all(each == set(enumerate(kinds, 1)) for each in everybody)
    assert simulation.seen.names == ("0", "person 0", "obstacle 0")
    assert tick.final.kind is EventKind.COLLISION
    assert (tick.final.object_names, tick.final.object_kinds) == (("0",), (ObjectKind.CAR,))
    ego, car = tick.scene.ego, tick.scene.objects.table[0]
    assert car["y"] - 0.5 * car["length"] - (ego.y + 0.5 * ego.length) == pytest.approx(0.0, abs=0.3)


def test_it_takes_no_actors():
    actor = Vehicle(id="v1", route=["south_in", "north_out"])
    content = scenario_on("town.sumocfg").model_dump() | {"actors": [actor.model_dump()]}
    with pytest.raises(InputError, match=r"town: there are actors in a SUMO configuration.*; see"):
        parse_scenario(content, "town")


@pytest.mark.parametrize(
    ("environment", "reach"),
    [
        ({}, math.inf),
        ({"weather": "foggy"}, 60.0),
        ({"time_of_day": "nighttime"}, 120.0),
        ({"weather": "foggy", "sensing_range": 30.0}, 30.0),
    ],
)
def test_one_sees_as_far_as_weather_and_light_allow(town, environment, reach):
    scenario = scenario_on(town, "south_in", "north_out", time_limit=0.1)
    with Simulation(scenario.model_copy(update={"environment": Environment(**environment)})) as simulation:
        ego, objects = (scene := simulation.first().scene).ego, scene.objects
    gaps = np.hypot(objects.x - ego.x, objects.y - ego.y)
    assert simulation._participants._range == reach
    assert gaps.max(initial=0.0) <= reach + 5.0  # SUMO looks at the front bumper


def test_the_ego_enters_where_there_is_room(town):
    gaps = []
    drive(scenario_on(town, "east_in", "west_out", time_limit=0.2), lambda _, tick: gaps.append(tick.min_distance))
    assert gaps[0] > 5.0


def test_a_goal_behind_the_place_where_there_is_room_is_named(town):
    with pytest.raises(InputError, match=r"ego\.goal: the ego starts at 40 m, and its goal is not ahead \(30\.0 m\)"):
        Simulation(scenario_on(town, "south_in", goal=30.0))


def test_the_traffic_has_been_under_way_for_as_long_as_asked(town):
    times = []
    drive(
        scenario_on(town, "south_in", "north_out", warm_up=42.0), lambda *_: times.append(libsumo.simulation.getTime())
    )
    assert times[0] == pytest.approx(142.0, abs=1.1)


def test_the_same_seed_gives_the_same_traffic(town):
    def places():
        seen = []
        drive(scenario_on(town, "south_in", "north_out"), lambda _, tick: seen.append(tick.scene.objects.x.tobytes()))
        return seen

    assert places() == places()


@pytest.mark.parametrize("place", ["shallow", "deep/er/and/deeper/still"])
def test_detectors_that_write_far_away_are_caught_too(town, tmp_path, place):
    there = tmp_path / place
    there.mkdir(parents=True)
    (town.parent / "near.add.xml").write_text(LOOP.format(name="near", file=there / "absolute.xml"))
    before = contents(tmp_path)
    drive(scenario_on(town, "south_in", "north_out", time_limit=0.5))
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("town.net.xml", "none.net.xml"), "net-file none.net.xml does not exist; mend the path"),
        (("demand.rou.xml", "none.rou.xml"), "route-files none.rou.xml does not exist; mend the path"),
        (("near.add.xml", "none.add.xml"), "additional-files none.add.xml does not exist; mend the path"),
        (('<net-file value="town.net.xml"/>', ""), "names no net-file; add"),
        (("</input>", ""), "broken XML"),
        (("<time>", '<time><step-method value="leap"/>'), "SUMO refuses it"),
    ],
)
def test_a_configuration_that_cannot_run_is_named_with_the_reason(town, change, words):
    town.write_text(CONFIGURATION.replace(*change))
    with pytest.raises(InputError, match=words) as caught:
        Simulation(scenario_on(town, "south_in", "north_out"))
    assert str(town) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("route", "words"),
    [
        (("south_in", "nowhere"), r"ego\.route\[1\]: there is no edge 'nowhere'"),
        (("south_in", "north_in"), "no lane leads from 'south_in' to 'north_in'"),
    ],
)
def test_a_route_that_cannot_be_is_named_before_anything_runs(town, route, words):
    with pytest.raises(InputError, match=words):
        Simulation(scenario_on(town, *route))


def test_without_traffic_there_is_no_route_to_take(town):
    (town.parent / "demand.rou.xml").write_text("<routes/>")
    with pytest.raises(InputError, match=r"ego\.route: no car is on the road to take a route from; name the edges"):
        Simulation(scenario_on(town))


def test_where_there_is_never_room_the_ego_stays_out_and_says_so(town):
    jam = "".join(
        f'<vehicle id="jam{number}" depart="100" departLane="1" departPos="{8 * number + 6}">'
        '<route edges="south_in"/><stop lane="south_in_1" endPos="95" until="9999"/></vehicle>'
        for number in range(11)
    )
    (town.parent / "demand.rou.xml").write_text(f"<routes>{jam}</routes>")
    with pytest.raises(InputError, match="no room for the ego on south_in within 120 s; begin on another edge"):
        Simulation(scenario_on(town, "south_in", "north_out"))


def test_options_that_would_take_the_ego_away_are_left_out(town, tmp_path):
    options = '<processing><time-to-teleport.highways value="5"/><ignore-route-errors value="true"/></processing>'
    town.write_text(town.read_text().replace("</configuration>", f"{options}</configuration>"))
    (tmp_path / "copy").mkdir()
    private_copy(town, tmp_path / "copy")
    copy = (tmp_path / "copy" / "user.sumocfg").read_text()
    assert "time-to-teleport" not in copy
    assert "ignore-route-errors" in copy
