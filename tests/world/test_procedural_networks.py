"""Generated SUMO configurations: the same bytes every time, and everything in them as SUMO reads it."""

import subprocess
from xml.etree import ElementTree as ET

import pytest

from roadmend.core.errors import SimulationError
from roadmend.world import procedural_networks
from roadmend.world.network import find_binary
from roadmend.world.procedural_networks import KINDS, NetworkRequest, generate_configuration
from roadmend.world.road_network import read_network


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_and_a_seed_give_the_same_files_that_sumo_runs(kind, tmp_path):
    path = generate_configuration(NetworkRequest(kind, 3, tmp_path / "here"))
    again = generate_configuration(NetworkRequest(kind, 3, tmp_path / "there"))
    assert path.name == f"{kind}-3.sumocfg"
    assert contents(path.parent) == contents(again.parent)
    assert str(tmp_path) not in "".join(data.decode() for data in contents(path.parent).values())
    command = [find_binary("sumo"), "-c", path.name, "--end", "30", "--no-step-log"]
    assert subprocess.run(command, cwd=path.parent, capture_output=True, check=False).returncode == 0


def test_seeds_differ(tmp_path):
    first, second = (generate_configuration(NetworkRequest("rural", seed, tmp_path)) for seed in (1, 2))
    sizes = {len(read_network(path.with_suffix(".net.xml")).roads) for path in (first, second)}
    assert len(sizes) == 2


@pytest.mark.slow
def test_a_city_has_lights_people_and_bicycles(tmp_path):
    path = generate_configuration(NetworkRequest("city", 1, tmp_path))
    network = read_network(path.with_suffix(".net.xml"))
    assert network.phases
    assert any(edge.function == "crossing" for edge in network.edges.values())
    routes = ET.parse(path.with_suffix(".rou.xml")).getroot()
    assert {vehicle.get("type") for vehicle in routes.iterfind("vehicle")} >= {"car", "truck", "bicycle"}
    assert routes.find("person") is not None
    departures = [float(one.attrib["depart"]) for one in routes if "depart" in one.attrib]
    assert departures == sorted(departures)


def test_a_motorway_has_ramps_and_bridges_that_meet_it_nowhere(tmp_path):
    network = read_network(generate_configuration(NetworkRequest("motorway", 1, tmp_path)).with_suffix(".net.xml"))
    assert any(name.endswith("-ramp") for name in network.edges)
    bridge, road = (network.edges[name] for name in ("south_1-north_1", "east_exit_1-ramp"))
    assert bridge.junctions == ("south_1", "north_1")
    assert "south_1" in road.junctions


def test_what_a_generator_says_is_told_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(procedural_networks, "_ring", lambda _numbers: ["--spider", "--spider.arm-number", "two"])
    with pytest.raises(SimulationError, match=r"netgenerate failed: .*spider\.arm-number") as caught:
        generate_configuration(NetworkRequest("ring", 1, tmp_path))
    assert "\n" not in str(caught.value)
