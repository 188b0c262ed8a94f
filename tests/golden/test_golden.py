"""Today's physics against yesterday's; ``physics.py`` beside this file shows what moved and renews the records."""

import importlib.util
from functools import cache
from pathlib import Path

import pytest

from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.world.scenario_file import save_scenario

_spec = importlib.util.spec_from_file_location("physics", Path(__file__).with_name("physics.py"))
physics = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(physics)

KEPT = physics.load()


@cache
def episodes():
    """By name; made by the first test that wants them, so that collecting the tests takes no scenario."""
    return {golden.name: golden for golden in physics.episodes()}


def test_the_records_are_of_these_episodes():
    assert sorted(KEPT) == sorted(episodes())
    assert len(episodes()) >= 60
    assert {record["outcome"] for record in KEPT.values()} >= {"GOAL", "COLLISION", "TIMEOUT"}


@pytest.mark.parametrize("name", KEPT)
def test_nothing_has_moved(name):
    assert physics.difference(KEPT[name], physics.drive(episodes()[name])) == ""


@pytest.mark.graph
@pytest.mark.parametrize(
    "name", ["S2-violation-modular-rss", "S4-violation-neural-adreft", "crash-report-neural-adreft"]
)
def test_the_graph_drives_them_alike(name, tmp_path):
    golden = episodes()[name]
    save_scenario(golden.scenario, tmp_path / "s.yaml")
    parameters = tuple(word for key, value in golden.parameters.items() for word in ("-p", f"adreft.{key}:={value}"))
    options = GraphOptions(
        tmp_path / "s.yaml", golden.policy, golden.method, record=False, viz=False, ros_arguments=parameters
    )
    result = run_graph(options).episode
    assert (result.digest, result.ticks) == (KEPT[name]["trajectory"], KEPT[name]["ticks"])


def test_what_moved_is_told():
    kept = next(iter(KEPT.values()))
    moved = {**kept, "trajectory": "0" * 64, "text": "otherwise", "trace": [[0.0] * 7]}
    assert physics.difference(kept, moved).startswith("text, trajectory; ")
    assert "by 0 s" in physics.difference(kept, moved)
    assert physics.difference(kept, {**kept, "scenes": "0"}) == "scenes; less than the trace shows"
