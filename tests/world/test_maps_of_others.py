"""SUMO configurations that were not made for roadmend: each drives to its goal, or is refused with the true reason.

Some are games that come with SUMO, the others are made here by SUMO's own tools. The larger ones take minutes and run
with ROADMEND_TEST_MAPS=1.
"""

import gzip
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.network import find_binary
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import drawn_scenarios
from roadmend.world.simulation import Simulation

SUMO = find_binary("sumo").parent.parent
GAMES = SUMO / "tools" / "game"
large = pytest.mark.skipif(not os.environ.get("ROADMEND_TEST_MAPS"), reason="takes minutes; set ROADMEND_TEST_MAPS=1")


def drive(path, seed=1, warm_up=60.0, time_limit=120.0):
    (scenario,) = drawn_scenarios([path], [seed], warm_up, time_limit)
    return run_episode(scenario, make_policy("modular"), make_repairer("none", seed=0))


class Maker:
    """Makes configurations in a folder with SUMO's tools."""

    def __init__(self, folder):
        self.folder = folder

    def tool(self, name, *arguments):
        program = [sys.executable, SUMO / "tools" / name] if name.endswith(".py") else [SUMO / "bin" / name]
        environment = {**os.environ, "SUMO_HOME": str(SUMO)}
        command = [str(each) for each in (*program, *arguments)]
        subprocess.run(command, cwd=self.folder, env=environment, check=True, capture_output=True)

    def netgenerate(self, *options):
        self.tool("netgenerate", *options, "--seed", 3, "-o", "town.net.xml")

    def trips(self, *options, name="cars"):
        given = ("-n", "town.net.xml", "-o", f"{name}.trips.xml", "--end", 600, "--seed", 4, "--prefix", name)
        self.tool("randomTrips.py", *given, *options)
        return f"{name}.trips.xml"

    def write(self, name, text):
        (self.folder / name).write_text(text)
        return name

    def configuration(self, *routes, options="", additional="", net="town.net.xml"):
        more = f'<additional-files value="{additional}"/>' if additional else ""
        text = f'<net-file value="{net}"/><route-files value="{",".join(routes)}"/>{more}'
        return self.folder / self.write(
            "town.sumocfg", f"<configuration><input>{text}</input>{options}</configuration>"
        )


@pytest.fixture
def maker(tmp_path, monkeypatch):
    monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path / "cache"))
    (tmp_path / "a town").mkdir()
    return Maker(tmp_path / "a town")


def grid(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "-L", 2)
    return maker.configuration(maker.trips("--period", 2))


def grid_with_lights_gzipped(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "--default-junction-type", "traffic_light")
    trips = maker.trips("--period", 2)
    for name in ("town.net.xml", trips):
        path = maker.folder / name
        (maker.folder / f"{name}.gz").write_bytes(gzip.compress(path.read_bytes()))
        path.unlink()
    return maker.configuration(f"{trips}.gz", net="town.net.xml.gz")


def spider(maker):
    maker.netgenerate("--spider", "--spider.arm-number", 6, "--spider.circle-number", 3, "--spider.space-radius", 140)
    return maker.configuration(maker.trips("--period", 2))


def streets_at_random(maker):
    maker.netgenerate("--rand", "--rand.iterations", 40, "--rand.min-distance", 90, "--random-priority")
    return maker.configuration(maker.trips("--period", 3, "--fringe-factor", 3))


def sidewalks_crossings_and_people(maker):
    sides = ("--sidewalks.guess", "--crossings.guess")
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 120, *sides)
    return maker.configuration(maker.trips("--period", 3), maker.trips("--pedestrians", "--period", 3, name="people"))


def bicycles_and_trams(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "-L", 2, "--bikelanes.guess")
    tram = (
        '<routes><vType id="tram" vClass="tram"/><flow id="t" type="tram" from="A0A1" to="A2A3" period="60" end="600"/>'
    )
    lines = maker.write("trams.rou.xml", f"{tram}</routes>")
    bicycles = maker.trips("--vehicle-class", "bicycle", "--period", 6, name="bikes")
    return maker.configuration(maker.trips("--period", 3), bicycles, lines)


def left_hand_traffic(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "-L", 2, "--lefthand")
    return maker.configuration(maker.trips("--period", 2))


def motorway_with_ramps(maker):
    nodes = {"a": (0, 0), "b": (800, 0), "c": (1600, 0), "d": (2600, 0), "on": (400, -200), "off": (2000, -200)}
    edges = [("a", "b", 2, 33.3), ("b", "c", 2, 33.3), ("c", "d", 2, 33.3), ("on", "b", 1, 16.7), ("c", "off", 1, 16.7)]
    lines = "".join(f'<node id="{name}" x="{x}" y="{y}"/>' for name, (x, y) in nodes.items())
    maker.write("m.nod.xml", f"<nodes>{lines}</nodes>")
    lines = "".join(
        f'<edge id="{begin}{end}" from="{begin}" to="{end}" numLanes="{lanes}" speed="{speed}"/>'
        for begin, end, lanes, speed in edges
    )
    maker.write("m.edg.xml", f"<edges>{lines}</edges>")
    maker.tool("netconvert", "-n", "m.nod.xml", "-e", "m.edg.xml", "--ramps.guess", "-o", "town.net.xml")
    flows = (("ab", "cd", 4), ("onb", "cd", 8), ("ab", "coff", 9))
    lines = "".join(
        f'<flow id="{a}{b}" from="{a}" to="{b}" period="{period}" end="600" departSpeed="max" departLane="free"/>'
        for a, b, period in flows
    )
    return maker.configuration(maker.write("m.rou.xml", f"<routes>{lines}</routes>"))


def detectors_everywhere(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "-L", 2)
    add = (
        '<e1Detector id="loop" lane="A0A1_0" pos="50" period="10" file="out/loop.xml"/>'
        '<e2Detector id="area" lane="B0B1_0" pos="10" length="50" period="10" file="area.xml"/>'
        '<e3Detector id="gate" period="10" file="gate.xml"><detEntry lane="A1A2_0" pos="9"/>'
        '<detExit lane="A1A2_0" pos="90"/></e3Detector>'
        '<edgeData id="edges" file="edges.xml" period="10"/>'
    )
    (maker.folder / "out").mkdir()
    outputs = '<output><tripinfo-output value="trips.xml"/><queue-output value="queues.xml"/></output>'
    detectors = maker.write("all.add.xml", f"<additional>{add}</additional>")
    return maker.configuration(maker.trips("--period", 2), additional=detectors, options=outputs)


def lights_with_a_program_of_their_own(maker):
    maker.netgenerate("--grid", "--grid.number", 3, "--grid.length", 200, "--grid.attach-length", 150)
    maker.tool("netconvert", "-s", "town.net.xml", "--tls.set", "B1", "-o", "lit.net.xml")
    maker.tool("netconvert", "-s", "lit.net.xml", "--plain-output-prefix", "plain")
    text = (maker.folder / "plain.tll.xml").read_text().replace('programID="0"', 'programID="night"')
    logics = text[text.index("<tlLogic ") : text.rindex("</tlLogic>")] + "</tlLogic>"
    program = maker.write("night.add.xml", f"<additional>{logics}</additional>")
    shutil.move(maker.folder / "lit.net.xml", maker.folder / "town.net.xml")
    return maker.configuration(maker.trips("--period", 2), additional=program)


def an_end_a_seed_and_a_port_of_its_own(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "-L", 2)
    options = (
        '<time><begin value="30"/><end value="50"/><step-length value="0.5"/></time>'
        '<random_number><random value="true"/><seed value="7"/></random_number>'
        '<traci_server><remote-port value="8813"/><num-clients value="1"/></traci_server>'
        '<processing><time-to-teleport value="10"/><collision.action value="remove"/></processing>'
        '<gui_only><gui-settings-file value="there is none.xml"/><start value="true"/></gui_only>'
    )
    return maker.configuration(maker.trips("--period", 1), options=options)


def a_network_alone(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150, "--sidewalks.guess", "--crossings.guess")
    return maker.folder / "town.net.xml"


def a_network_alone_gzipped(maker):
    maker.netgenerate("--spider", "--spider.arm-number", 5, "--spider.circle-number", 3, "--spider.space-radius", 150)
    path = maker.folder / "town.net.xml"
    (maker.folder / "town.net.xml.gz").write_bytes(gzip.compress(path.read_bytes()))
    path.unlink()
    return maker.folder / "town.net.xml.gz"


def game(name):
    made = lambda _maker: GAMES / f"{name}.sumocfg"
    made.__name__ = f"game_{Path(name).name}"
    return made


@pytest.mark.parametrize(
    ("make", "seed"),
    [
        (grid, 1),
        (grid_with_lights_gzipped, 1),
        (spider, 1),
        (streets_at_random, 1),
        (sidewalks_crossings_and_people, 1),
        (bicycles_and_trams, 1),
        (left_hand_traffic, 1),
        (motorway_with_ramps, 1),
        (detectors_everywhere, 1),
        (lights_with_a_program_of_their_own, 1),
        (an_end_a_seed_and_a_port_of_its_own, 1),
        (a_network_alone, 1),
        (a_network_alone_gzipped, 1),
        (game("cross"), 1),
        (game("corridor"), 1),
        (game("ramp"), 1),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_a_careful_policy_comes_to_its_goal(make, seed, maker):
    path = make(maker)
    before = sorted(maker.folder.rglob("*"))
    assert drive(path, seed).outcome is EventKind.GOAL
    assert sorted(maker.folder.rglob("*")) == before  # nothing is left beside what belongs to somebody else


def test_an_ego_that_stands_is_not_taken_away_as_traffic_of_the_configuration_would_be(maker):
    path = motorway_with_ramps(maker)
    teleports = '<processing><time-to-teleport.highways value="2"/><time-to-teleport value="2"/></processing>'
    path.write_text(path.read_text().replace("</configuration>", f"{teleports}</configuration>"))
    (scenario,) = drawn_scenarios([path], [1], 30.0, 60.0)
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        while tick.final is None and tick.scene.time < 20.0:
            tick = simulation.step(Command(0.0, 1.0))
        assert tick.scene.ego.speed == 0.0
        assert tick.final is None or tick.final.kind is EventKind.COLLISION  # somebody may run into it


@large
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed"),
    [("DRT", 2), ("DRT2", 1), ("DRT_demo", 1), ("A10KW", 1), ("fkk_in", 1), ("fokr_bs_demo", 2), ("cross_demo", 2)],
)
def test_larger_games_are_driven_too(name, seed, maker):
    assert drive(GAMES / f"{name}.sumocfg", seed).outcome is EventKind.GOAL


def test_where_no_car_has_a_route_of_use_the_ego_gets_one_of_its_own(maker):
    maker.netgenerate("--grid", "--grid.number", 4, "--grid.length", 150)
    bus = '<routes><vType id="bus" vClass="bus"/><flow id="b" type="bus" from="A0A1" to="A2A3" period="20" end="600"/>'
    result = drive(maker.configuration(maker.write("buses.rou.xml", f"{bus}</routes>")))
    assert result.outcome is EventKind.GOAL
    assert result.distance > 100.0


def test_who_waits_at_a_light_that_never_changes_is_not_said_to_have_arrived(maker):
    """The phases of this game last 10 000 s, and a player ends them."""
    result = drive(GAMES / "square.sumocfg", time_limit=30.0)
    assert result.outcome is EventKind.TIMEOUT
    assert result.distance < 100.0


def people_alone(_maker):
    return GAMES / "hiking" / "hiking.sumocfg"


def rails(_maker):
    return GAMES / "rail.sumocfg"


def rails_alone(_maker):
    return GAMES / "rail" / "net.net.xml"


def roads_for_others(_maker):
    return GAMES / "racing" / "racing.sumocfg"  # for the class "vip" alone


def routes_that_are_not_there(maker):
    maker.netgenerate("--grid", "--grid.number", 3)
    return maker.configuration("none.rou.xml")


def a_vehicle_named_ego(maker):
    maker.netgenerate("--grid", "--grid.number", 3)
    text = '<routes><trip id="ego" depart="55" from="A0A1" to="C1C2"/></routes>'
    return maker.configuration(maker.write("own.rou.xml", text))


def a_trip_that_leads_nowhere(maker):
    maker.netgenerate("--grid", "--grid.number", 3)
    text = '<routes><trip id="lost" depart="0" from="A0A1" to="nowhere"/></routes>'
    return maker.configuration(maker.write("own.rou.xml", text))


def an_option_that_sumo_does_not_know(maker):
    maker.netgenerate("--grid", "--grid.number", 3)
    return maker.configuration(maker.trips("--period", 9), options='<processing><hurry value="true"/></processing>')


def one_road_alone(maker):
    maker.write("o.nod.xml", '<nodes><node id="a" x="0" y="0"/><node id="b" x="90" y="0"/></nodes>')
    maker.write("o.edg.xml", '<edges><edge id="ab" from="a" to="b"/></edges>')
    maker.tool("netconvert", "-n", "o.nod.xml", "-e", "o.edg.xml", "-o", "town.net.xml")
    return maker.folder / "town.net.xml"


def two_places_apart(maker):
    nodes = {"a": (0, 0), "b": (60, 0), "c": (30, 50), "d": (3000, 0), "e": (3060, 0), "f": (3030, 50)}
    lines = "".join(f'<node id="{name}" x="{x}" y="{y}"/>' for name, (x, y) in nodes.items())
    maker.write("o.nod.xml", f"<nodes>{lines}</nodes>")
    lines = "".join(f'<edge id="{way}" from="{way[0]}" to="{way[1]}"/>' for way in ("ab", "bc", "ca", "de", "ef", "fd"))
    maker.write("o.edg.xml", f"<edges>{lines}</edges>")
    maker.tool("netconvert", "-n", "o.nod.xml", "-e", "o.edg.xml", "-o", "town.net.xml")
    return maker.folder / "town.net.xml"


def half_a_network(maker):
    maker.netgenerate("--grid", "--grid.number", 3)
    path = maker.folder / "town.net.xml"
    path.write_text(path.read_text()[:5000])
    return path


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (people_alone, "nobody is on the road until 180 s"),
        (rails, "no lane for cars"),
        (rails_alone, "no lane for cars"),
        (roads_for_others, "no lane for cars"),
        (routes_that_are_not_there, "route-files none.rou.xml does not exist"),
        (a_vehicle_named_ego, "has a vehicle 'ego' of its own"),
        (a_trip_that_leads_nowhere, "nowhere"),
        (an_option_that_sumo_does_not_know, "hurry"),
        (one_road_alone, "gets no traffic"),
        (two_places_apart, "no way for cars between two of its roads"),
        (half_a_network, "broken XML"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_what_no_ego_can_drive_on_is_refused_in_a_line_with_the_reason(make, reason, maker, capfd):
    path = make(maker)
    with pytest.raises(InputError, match=reason) as caught:
        drive(path)
    assert str(path.parent) in str(caught.value)  # the configuration, or its network
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""
