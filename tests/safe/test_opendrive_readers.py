"""Exported roads as other people's readers see them: ASAM's checker, pyxodr, and CommonRoad's converter.

pyxodr and CommonRoad are compared with the crash in the scenario language: lanes, bends, arms, stem. CommonRoad's
converter (commonroad-scenario-designer) is large and no requirement of the tests; where it is not installed, it is
not asked.
"""

import math

import pytest

from harness.outside_readers import headings, issues_by_asam_opendrive, lines_by_commonroad, roads_by_pyxodr
from roadmend.safe.construction import draw_scenario
from roadmend.safe.dsl import Compass
from roadmend.safe.openscenario import export_scenario
from roadmend.world.network import network_file
from roadmend.world.opendrive import write_opendrive
from roadmend.world.scenario_networks import (
    Arm,
    HighwayExitNetwork,
    IntersectionNetwork,
    OnRampNetwork,
    OpenRoadNetwork,
)

from .crashes import ALL, role

OPEN_ROADS = [
    name for name, crash in ALL.items() if crash.road.road_type in {"Straight", "Curve"} and name != "driveway"
]
JUNCTIONS = ["intersection", "tee"]
ARMS = [Arm(name=name, bearing=bearing, lanes=2) for name, bearing in (("e", 0), ("n", 90), ("w", 180), ("s", 270))]
NETWORKS = {
    "traffic light": IntersectionNetwork(arms=ARMS, control="traffic_light"),
    "stop signs": IntersectionNetwork(arms=ARMS, control="priority_stop"),
    "crossings": IntersectionNetwork(arms=ARMS, crossings=True),
    "divided": IntersectionNetwork(arms=[ARMS[0].model_copy(update={"median": 8.0}), *ARMS[1:]]),
    "exit": HighwayExitNetwork(),
    "ramp to the north": OnRampNetwork(bearing=90.0),
    "one way": OpenRoadNetwork(backward_lanes=0),
    "divided bend": OpenRoadNetwork(lanes=2, backward_lanes=2, bend=-60.0, radius=200.0, median=6.0),
}


@pytest.fixture
def exported(tmp_path):
    def run(name):
        scenario = draw_scenario(role(ALL[name]), 0).model_copy(update={"name": name.replace(" ", "-")})
        return scenario, export_scenario(scenario, tmp_path)[1]

    return run


@pytest.mark.parametrize("name", ["straight", "curve", "tee", "merging", "driveway"])
def test_the_checker_of_asam_finds_nothing_in_a_reports_roads(exported, tmp_path, name):
    pytest.importorskip("qc_opendrive")
    found, checks = issues_by_asam_opendrive(exported(name)[1], tmp_path)
    assert found == []
    assert checks >= 20


@pytest.mark.parametrize("name", NETWORKS)
def test_the_checker_of_asam_finds_nothing_in_any_kind_of_network(tmp_path, name):
    pytest.importorskip("qc_opendrive")
    write_opendrive(network_file(NETWORKS[name]), tmp_path / "roads.xodr")
    assert issues_by_asam_opendrive(tmp_path / "roads.xodr", tmp_path)[0] == []


@pytest.mark.parametrize("name", OPEN_ROADS)
def test_pyxodr_sees_the_lanes_and_the_bend_of_an_open_road(exported, name):
    pytest.importorskip("pyxodr")
    scenario, path = exported(name)
    lanes, starts, turns, _ = zip(*roads_by_pyxodr(path), strict=True)
    told = ALL[name].road.lanes
    assert sum(lanes) == (told if told is not None else scenario.origin.sampled["lanes"])
    network = scenario.network
    ways = [
        (math.cos(math.radians(heading)), math.sin(math.radians(heading)), turn)
        for heading, turn in zip(starts, turns, strict=True)
    ]
    bearing, end = (math.radians(angle) for angle in (network.bearing, network.bearing + network.bend + 180.0))
    wanted = [(math.cos(bearing), math.sin(bearing), network.bend), (math.cos(end), math.sin(end), -network.bend)]
    for way in ways:
        assert any(way == pytest.approx(each, abs=0.05) for each in wanted)


@pytest.mark.parametrize("name", JUNCTIONS)
def test_pyxodr_sees_the_arms_the_stem_and_the_lanes_of_the_larger_road(exported, name):
    pytest.importorskip("pyxodr")
    _, path = exported(name)
    lanes: dict[int, int] = {}
    for count, _, turn, line in roads_by_pyxodr(path):
        outer = max((line[0], line[-1]), key=lambda point: math.hypot(*point))
        side = round(math.degrees(math.atan2(outer[1], outer[0]))) % 360
        lanes[side] = lanes.get(side, 0) + count
        assert turn == pytest.approx(0.0, abs=0.1)
    road = ALL[name].road
    assert max(lanes.values()) == road.lanes
    sides = {0: Compass.EAST, 90: Compass.NORTH, 180: Compass.WEST, 270: Compass.SOUTH}
    there = {sides[side] for side in lanes}
    if road.stem is None:
        assert there == {*Compass}
    else:
        opposite = sides[(next(angle for angle, side in sides.items() if side is road.stem) + 180) % 360]
        assert there == {*Compass} - {opposite}


def test_pyxodr_sees_the_lanes_of_a_merging(exported):
    pytest.importorskip("pyxodr")
    _, path = exported("merging")
    assert sorted(count for count, *_ in roads_by_pyxodr(path)) == [1, 2, 2, 3]


@pytest.mark.parametrize("name", ALL)
def test_commonroads_converter_sees_as_many_lanes_and_the_same_bend(exported, name):
    pytest.importorskip("crdesigner")
    scenario, path = exported(name)
    lines = lines_by_commonroad(path)
    assert lines
    if name in OPEN_ROADS:
        assert len(lines) == scenario.network.lanes + scenario.network.backward_lanes
        turns = [headings(line)[1] for line in lines]
        assert [abs(turn) for turn in turns] == pytest.approx([abs(scenario.network.bend)] * len(turns), abs=3.0)
