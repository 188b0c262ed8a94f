"""SUMO configurations of others' making: each drive comes to an outcome, or is refused with the reason."""

import gzip
import subprocess

import libsumo
import pytest

from roadmend.core.command import Command
from roadmend.core.errors import InputError, SimulationError
from roadmend.core.outcome import EventKind
from roadmend.core.tick import INTERVAL
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.network import find_binary
from roadmend.world.procedural_networks import NetworkRequest, generate_configuration
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Ego, Environment, Scenario
from roadmend.world.scenario_file import drawn_scenarios
from roadmend.world.scenario_networks import NetworkFile, SumoConfiguration
from roadmend.world.simulation import Simulation

FLOW = '<flow id="flow{0}" begin="0" end="900" period="15" from="{1}" to="{2}" departLane="best"/>'


def draw(path, seed=1, warm_up=60.0, time_limit=120.0):
    return drawn_scenarios([path], [seed], warm_up, time_limit)[0]


def drive(scenario):
    return run_episode(scenario, make_policy("modular"), make_repairer("none", seed=0))


def stand(simulation, duration):
    for _ in range(round(duration / INTERVAL)):
        simulation.step(Command(0.0, 1.0))


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    return generate_configuration(NetworkRequest("ring", 1, tmp_path_factory.mktemp("ring")))


@pytest.fixture
def own(ring, tmp_path):
    """Writes a configuration on the ring's network, with options and routes of one's own."""

    def write(options="", routes=None, net=None):
        folder = tmp_path / "of mine"
        folder.mkdir(exist_ok=True)
        files = [net or ring.with_suffix(".net.xml"), ring.with_suffix(".rou.xml")]
        if routes is not None:
            files[1] = folder / "own.rou.xml"
            files[1].write_text(f"<routes>{routes}</routes>")
        path = folder / "own.sumocfg"
        path.write_text(f'<configuration><n v="{files[0]}"/><r v="{files[1]}"/>{options}</configuration>')
        return path

    return write


@pytest.mark.parametrize("kind", ["ring", "motorway", "rural"])
def test_a_drawn_drive_on_a_generated_network_reaches_its_goal(kind, tmp_path):
    result = drive(draw(generate_configuration(NetworkRequest(kind, 2, tmp_path)), warm_up=120.0))
    assert result.outcome is EventKind.GOAL


@pytest.mark.slow
def test_a_city_with_lights_and_people_comes_to_an_outcome(tmp_path):
    assert drive(draw(generate_configuration(NetworkRequest("city", 2, tmp_path)))).outcome in set(EventKind)


def test_seeds_draw_other_routes_and_the_same_seed_the_same(ring):
    def start(seed):
        with Simulation(draw(ring, seed)) as simulation:
            ego = simulation.scenario.ego
            return tuple(ego.route), ego.position, ego.speed, simulation.route.length

    starts = [start(seed) for seed in (1, 2, 3)]
    assert len(set(starts)) == 3
    assert starts[0] == start(1)
    assert all(300.0 < length < 950.0 for *_, length in starts)
    assert all(speed > 3.0 for _, _, speed, _ in starts)


@pytest.mark.parametrize(
    "options",
    [
        '<time><begin value="0"/><end value="20"/></time>',
        '<random_number><random value="true"/></random_number>',
        '<traci_server><remote-port value="8813"/><num-clients value="2"/></traci_server>',
        '<save-state.times value="5"/><fcd-output value="fcd.xml"/><netstate-dump value="dump.xml"/>',
        '<processing><time-to-teleport value="5"/><threads value="2"/></processing>',
        '<processing><lateral-resolution value="0.8"/><step-length value="1"/></processing>',
    ],
)
def test_options_that_serve_other_ends_change_nothing(own, options, tmp_path):
    path = own(options)
    before = sorted(tmp_path.rglob("*"))
    first, second = (drive(draw(path, time_limit=10.0)) for _ in range(2))
    assert first.digest == second.digest
    assert sorted(tmp_path.rglob("*")) == before


def test_a_compressed_network_is_read(own, ring, tmp_path):
    net = tmp_path / "packed.net.xml.gz"
    net.write_bytes(gzip.compress(ring.with_suffix(".net.xml").read_bytes()))
    assert drive(draw(own(net=net), time_limit=5.0)).outcome is EventKind.TIMEOUT
    net.write_bytes(net.read_bytes()[:900])
    with pytest.raises(InputError, match="broken XML"):
        drive(draw(own(net=net)))


def test_variables_of_the_environment_in_names_are_followed(ring, tmp_path, monkeypatch):
    monkeypatch.setenv("TOWNS", str(ring.parent))
    path = tmp_path / "own.sumocfg"
    path.write_text(ring.read_text().replace('value="ring-1', 'value="${TOWNS}/ring-1'))
    assert drive(draw(path, time_limit=1.0)).outcome is EventKind.TIMEOUT


@pytest.mark.parametrize(
    ("options", "routes", "words"),
    [
        ('<mesosim value="true"/>', None, "simulates queues and not vehicles"),
        ("", "", "nobody is on the road until 180 s; choose another --warm-up"),
        ("", '<vehicle id="ego" depart="50"><route edges="A1B1 B1C1"/></vehicle>', "has a vehicle 'ego' of its own"),
        ("", '<vehicle id="a" depart="0"><route edges="A1B1 C3B3"/></vehicle>', "has no valid route"),
        ("", '<vehicle id="a" depart="0"><route edges="nowhere"/></vehicle>', "nowhere"),
        ('<processing><leap value="1"/></processing>', None, "SUMO refuses it"),
    ],
)
def test_what_cannot_be_driven_is_refused_in_a_line_with_the_reason(own, options, routes, words, capfd):
    if routes:
        routes = routes.replace("A1B1", "B1B2").replace("B1C1", "B2B3").replace("C3B3", "C1B1")
    path = own(options, routes)
    with pytest.raises(InputError, match=words) as caught:
        drive(draw(path))
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_a_route_that_turns_out_broken_later_ends_the_drive_with_the_reason(own):
    cars = "".join(
        f'<vehicle id="a{n}" depart="{n}"><route edges="B1B2 B2B3 B3B4 B4B5"/></vehicle>' for n in range(300)
    )
    path = own(routes=cars + '<vehicle id="bad" depart="300"><route edges="nowhere"/></vehicle>')
    with Simulation(draw(path, warm_up=60.0, time_limit=600.0)) as simulation:
        simulation.first()
        with pytest.raises(SimulationError, match="nowhere") as caught:
            stand(simulation, 300.0)
    assert "\n" not in str(caught.value)


def test_those_who_park_ride_or_leave_are_no_trouble(own):
    route = '<route edges="B1B2 B2B3 B3B4 B4B5"/>'
    cars = "".join(f'<vehicle id="car{number}" depart="{4 * number}">{route}</vehicle>' for number in range(40))
    routes = (
        '<vType id="bus" vClass="bus"/>'
        + cars
        + '<vehicle id="bus" type="bus" depart="160"><route edges="B1B2 B2B3 B3B4 B4B5"/></vehicle>'
        + '<person id="rider" depart="160" departPos="0"><ride from="B1B2" to="B4B5" lines="bus"/></person>'
        + '<vehicle id="parked" depart="160"><route edges="B1B2 B2B3"/>'
        + '<stop lane="B1B2_0" endPos="60" duration="500" parking="true"/></vehicle>'
    )
    scenario = draw(own(routes=routes), time_limit=60.0)
    assert drive(scenario).outcome in {EventKind.GOAL, EventKind.TIMEOUT}


def test_passengers_are_not_people_on_foot(own):
    routes = (
        '<vehicle id="taxi" depart="0"><route edges="B1B2 B2B3 B3B4 B4B5"/></vehicle>'
        '<person id="rider" depart="triggered"><ride from="B1B2" to="B4B5" lines="taxi"/></person>'
    )
    network = SumoConfiguration(path=str(own(routes=routes)), warm_up=5.0)
    with Simulation(Scenario(name="ride", network=network, ego=Ego(route=["C1B1", "B1B2"]))) as simulation:
        simulation.first()
        assert simulation.seen is not None
        assert libsumo.person.getIDList() == ("rider",)
        assert simulation.seen.names == ("taxi",)


def test_who_is_on_a_bridge_over_the_way_is_not_there(tmp_path):
    path = generate_configuration(NetworkRequest("motorway", 1, tmp_path))
    edges = [line for line in path.with_suffix(".rou.xml").read_text().split('"') if "south_1-north_1" in line]
    assert edges
    network = SumoConfiguration(path=str(path), warm_up=60.0)
    route = [part for part in ("east_exit_1-east_entry_1",) if part in path.with_suffix(".net.xml").read_text()]
    scenario = Scenario(name="under", network=network, ego=Ego(route=route), environment=Environment())
    with Simulation(scenario) as simulation:
        simulation.first()
        assert {"south_1-north_1", "north_1-south_1"} <= simulation._participants._elsewhere
        assert all(libsumo.vehicle.getRoadID(name) != "south_1-north_1" for name in simulation.seen.names)


def test_trams_and_their_tracks_are_no_trouble(tmp_path):
    (tmp_path / "t.nod.xml").write_text(
        '<nodes><node id="w" x="-400" y="0"/><node id="c" x="0" y="0"/><node id="e" x="400" y="0"/>'
        '<node id="s" x="0" y="-400"/><node id="n" x="0" y="400"/></nodes>'
    )
    (tmp_path / "t.edg.xml").write_text(
        '<edges><edge id="wc" from="w" to="c"/><edge id="ce" from="c" to="e"/>'
        '<edge id="sc" from="s" to="c" allow="tram"/><edge id="cn" from="c" to="n" allow="tram"/></edges>'
    )
    command = [find_binary("netconvert"), "-n", "t.nod.xml", "-e", "t.edg.xml", "-o", "t.net.xml", "--no-warnings"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    flow = FLOW.format("t", "sc", "cn").replace("<flow ", '<flow type="tram" ')
    (tmp_path / "t.rou.xml").write_text(
        f'<routes><vType id="tram" vClass="tram"/>{FLOW.format("c", "wc", "ce")}{flow}</routes>'
    )
    path = tmp_path / "t.sumocfg"
    path.write_text('<configuration><net-file value="t.net.xml"/><route-files value="t.rou.xml"/></configuration>')
    result = drive(draw(path))
    assert result.outcome in {EventKind.GOAL, EventKind.TIMEOUT}


def test_an_ego_as_long_as_a_lorry_comes_round_a_roundabout(tmp_path):
    (tmp_path / "r.nod.xml").write_text(
        '<nodes><node id="w" x="-20" y="0"/><node id="n" x="0" y="20"/><node id="e" x="20" y="0"/>'
        '<node id="s" x="0" y="-20"/><node id="west" x="-200" y="0"/><node id="east" x="200" y="0"/>'
        '<node id="south" x="0" y="-200"/></nodes>'
    )
    edges = ("ws w s", "se s e", "en e n", "nw n w", "in west w", "out e east", "down s south")
    words = (edge.split() for edge in edges)
    text = "".join(f'<edge id="{name}" from="{begin}" to="{end}" speed="8"/>' for name, begin, end in words)
    (tmp_path / "r.edg.xml").write_text(f'<edges>{text}<roundabout nodes="w s e n" edges="ws se en nw"/></edges>')
    command = [find_binary("netconvert"), "-n", "r.nod.xml", "-e", "r.edg.xml", "-o", "r.net.xml", "--no-warnings"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    ego = Ego(route=("ws", "se", "en", "nw"), position=10.0, speed=8.0, length=9.0, width=2.4)
    network = NetworkFile(path=str(tmp_path / "r.net.xml"))
    result = drive(Scenario(name="round", network=network, ego=ego, time_limit=60.0))
    assert result.outcome is EventKind.GOAL


def test_a_folder_stands_for_all_configurations_below(tmp_path, ring):
    for name in ("a", "b/c"):
        (tmp_path / name).mkdir(parents=True)
        text = ring.read_text().replace('value="ring-1.', f'value="{ring.parent}/ring-1.')
        (tmp_path / name / "run.sumocfg").write_text(text)
    scenarios = drawn_scenarios([tmp_path], [5, 6], 60.0, 30.0)
    stem = tmp_path.name.replace("[", "_").replace("]", "_")
    assert [scenario.name for scenario in scenarios] == [
        f"{stem}-{rest}" for rest in ("a-run-5", "a-run-6", "b-c-run-5", "b-c-run-6")
    ]
    with pytest.raises(InputError, match="is called"):
        drawn_scenarios([tmp_path, tmp_path], [0], 60.0, 30.0)


def test_a_link_in_a_folder_goes_by_its_own_name(tmp_path, ring):
    (tmp_path / "towns").mkdir()
    (tmp_path / "towns" / "mine.sumocfg").symlink_to(ring)
    (scenario,) = drawn_scenarios([tmp_path / "towns"], [5], 60.0, 30.0)
    assert scenario.name == "towns-mine-5"
    assert scenario.network.path == str(ring.resolve())


def test_kept_results_are_told_apart_by_what_the_files_hold(own):
    path = own()
    before = draw(path).digest
    path.write_text(path.read_text() + "\n")
    assert draw(path).digest != before
