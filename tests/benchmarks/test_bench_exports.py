"""``roadmend bench exports``: every reader that is there opens every file, and one that is not right is seen not to be."""

import json
from types import SimpleNamespace

import pytest

from bench import main
from harness import bench_exports, outside_readers
from roadmend.world.scenario_networks import OpenRoadNetwork


@pytest.fixture
def measured(tmp_path, capsys):
    def run(*words):
        assert (
            main(["exports", "config/reports/straight", "--out", str(tmp_path), "--json", "--workers", "1", *words])
            == 0
        )
        content = json.loads((tmp_path / "exports.json").read_text())
        assert json.loads(capsys.readouterr().out) == content
        return content

    return run


def test_what_is_there_opens_them_and_what_is_not_is_named(measured):
    content = measured()
    assert content["reports"] == content["built"] == 1
    assert {*content["readers"], *content["not_installed"]} == {*bench_exports._PACKAGES}
    for name in {"pyxodr", "ASAM OpenDRIVE checker"} & {*content["readers"]}:
        figures = content["readers"][name]
        assert figures["files"] == figures["opened"] == 1
        assert figures["problems"] == []


def test_a_file_that_does_not_open_counts_with_its_reason(measured, monkeypatch):
    def broken(_path):
        raise KeyError("lane")

    monkeypatch.setattr(bench_exports, "find_spec", lambda package: object() if package == "pyxodr" else None)
    monkeypatch.setattr(outside_readers, "roads_by_pyxodr", broken)
    figures = measured()["readers"]["pyxodr"]
    assert (figures["files"], figures["opened"]) == (1, 0)
    assert figures["problems"] == ["KeyError: 'lane'"]


@pytest.mark.parametrize(
    ("heading", "turn", "right"),
    [
        (90.0, -60.0, True),
        (-150.0, 60.0, True),  # against it
        (210.0, 60.0, True),
        (90.0, 60.0, False),  # to the other side
        (-150.0, -60.0, False),
        (90.0, -50.0, False),
        (90.0, 0.0, False),
        (0.0, -60.0, False),
    ],
)
def test_a_bend_is_right_where_it_turns_as_it_was_built(heading, turn, right):
    network = OpenRoadNetwork(bend=-60.0, radius=200.0, bearing=90.0)
    told = SimpleNamespace(road_type=bench_exports.RoadType.CURVE)
    assert bench_exports._is_bend_right([(90.0, -60.0), (heading, turn)], network, told, 1.0) is right


def test_a_bent_road_is_not_right_where_the_report_has_a_straight_one():
    told = SimpleNamespace(road_type=bench_exports.RoadType.STRAIGHT)
    network = OpenRoadNetwork(bend=-60.0, radius=200.0)
    assert not bench_exports._is_bend_right([(network.bearing, -60.0)], network, told, 1.0)
