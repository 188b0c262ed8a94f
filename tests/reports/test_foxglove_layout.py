"""The Foxglove layout: its structure, and that every topic and field in it exists in the graph."""

import importlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from foxglove import layouts
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PlannedPath
from roadmend_msgs import msg
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from roadmend.recording import topics

LAYOUT = Path(__file__).parents[2] / "config" / "foxglove" / "roadmend.json"

TYPES = {
    topics.EGO: Odometry,
    topics.REPAIR_STATE: msg.RepairState,
    topics.EVENTS: msg.ScenarioEvent,
    topics.DIAGNOSTICS: DiagnosticArray,
    topics.DISTANCE: Float64,
    topics.MARKERS_EGO: MarkerArray,
    topics.MARKERS_MAP: MarkerArray,
    topics.MARKERS_OBJECTS: MarkerArray,
    topics.MARKERS_PLAN: MarkerArray,
    topics.PLAN: PlannedPath,
}
TOPICS = {f"/{topic.removeprefix('/')}": kind for topic, kind in TYPES.items()}


@pytest.fixture(scope="module")
def layout() -> dict[str, Any]:
    return json.loads(LAYOUT.read_text(encoding="utf-8"))


# The panels by the type that a layout file names, with Foxglove's own account of what their settings may be.
PANELS = {
    "3D": layouts.ThreeDeeConfig,
    "Plot": layouts.PlotConfig,
    "StateTransitions": layouts.StateTransitionsConfig,
    "DiagnosticSummary": layouts.DiagnosticsSummaryConfig,
    "RawMessages": layouts.RawMessagesConfig,
}
SERIES = {"Plot": layouts.PlotSeries, "StateTransitions": layouts.StateTransitionsSeries}
PLAIN = {"Parameters", "Tab"}  # panels without settings of that kind


def panels_of(node: Any) -> Iterator[str]:
    """Panel ids in a mosaic, which is an id or a split of two mosaics."""
    if isinstance(node, str):
        yield node
        return
    assert set(node) <= {"direction", "first", "second", "splitPercentage"}
    assert node["direction"] in {"row", "column"}
    assert 0 < node["splitPercentage"] < 100
    yield from panels_of(node["first"])
    yield from panels_of(node["second"])


def message_paths(layout: dict[str, Any]) -> Iterator[str]:
    """Every topic, with or without a field, that any panel names."""
    for name, panel in layout["configById"].items():
        yield from panel.get("topics", {})
        yield from (path["value"] for path in panel.get("paths", []))
        yield from (panel[key] for key in ("topicPath", "topicToRender") if key in panel)
        assert name.partition("!")[2]


def test_top_level_is_what_foxglove_imports(layout: dict[str, Any]) -> None:
    assert set(layout) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    assert layout["playbackConfig"]["speed"] > 0


def test_every_panel_is_placed_once_and_configured(layout: dict[str, Any]) -> None:
    placed = list(panels_of(layout["layout"]))
    for name, panel in layout["configById"].items():
        if name.startswith("Tab!"):
            assert 0 <= panel["activeTabIdx"] < len(panel["tabs"])
            for tab in panel["tabs"]:
                assert tab["title"]
                placed += panels_of(tab["layout"])
    assert sorted(placed) == sorted(layout["configById"])


def test_every_topic_and_field_exists_in_the_graph(layout: dict[str, Any]) -> None:
    paths = list(message_paths(layout))
    assert len(paths) > 10
    for path in paths:
        topic, *fields = path.split(".")
        assert topic in TOPICS, path
        kind = TOPICS[topic]
        for depth, name in enumerate(fields):
            known = kind.get_fields_and_field_types()
            assert name in known, path
            if depth < len(fields) - 1:
                package, kind_name = known[name].split("/")
                kind = getattr(importlib.import_module(f"{package}.msg"), kind_name)


def test_scene_follows_the_ego_and_shows_all_markers(layout: dict[str, Any]) -> None:
    scene = layout["configById"]["3D!scene"]
    assert scene["followTf"] == "base_link"
    shown = {topic for topic, settings in scene["topics"].items() if settings["visible"]}
    assert shown == {topic for topic, kind in TOPICS.items() if kind is MarkerArray}
    assert {layer["frameId"] for layer in scene["layers"].values()} == {"map"}


def test_every_setting_is_one_that_foxglove_knows(layout: dict[str, Any]) -> None:
    kinds = {name.partition("!")[0] for name in layout["configById"]}
    assert kinds == set(PANELS) | PLAIN  # what a bag and the live graph are looked at with
    for name, settings in layout["configById"].items():
        kind = name.partition("!")[0]
        if kind in PANELS:
            assert set(settings) - {"foxglovePanelTitle"} <= set(PANELS[kind]()._to_dict()), name
        for series in settings.get("paths", []):
            assert set(series) <= set(SERIES[kind](value="/topic")._to_dict()), name


def test_the_score_is_plotted_against_its_threshold_and_what_was_asked_with_what_was_sent(
    layout: dict[str, Any],
) -> None:
    plots = [
        {path["value"] for path in panel["paths"]}
        for name, panel in layout["configById"].items()
        if name.startswith(("Plot!", "StateTransitions!"))
    ]
    for together in (
        {"/repair/state.score", "/repair/state.threshold"},
        {"/repair/state.policy_action", "/repair/state.final_action"},
        {"/repair/state.state"},
    ):
        assert any(together <= plot for plot in plots), together
