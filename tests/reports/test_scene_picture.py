"""Pictures: something is drawn where it should be, in the colour it should have."""

import dataclasses
import io
import itertools
import math

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from roadmend.core.appearance import KIND_COLOUR, SILENT_COLOUR, STATUS_COLOUR, TRIGGER_COLOUR
from roadmend.core.command import Command, Trajectory
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair, RepairStatus, RepairTrigger
from roadmend.core.route import RightOfWay, Route, Stage, Zone
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.core.spell import Spell
from roadmend.core.spell_account import SpellAccount
from roadmend.reports.scene_layers import ASPHALT, Trail
from roadmend.reports.scene_picture import SceneView, draw_scene
from roadmend.reports.scene_timeline import SILENT, Band, Timeline, draw_timeline, rows_of
from roadmend.world.road_network import LaneKind, LaneMap

Pixels = NDArray[np.uint8]


def timeline(count: int = 200) -> Timeline:
    """Two interventions."""
    time = np.arange(count) * 0.05
    flag = ((time > 2.0) & (time < 3.0)) | (time > 9.0)
    action = np.sin(time)
    return Timeline(
        time,
        5.0 + np.cos(time),
        10.0 - time,
        np.where(flag, 0.9, 0.1),
        np.full(count, 0.5),
        action,
        np.where(flag, -0.8, action),
        flag,
        flag.astype(np.int64),
    )


def view() -> SceneView:
    """The ego on a road with a car ahead and a pedestrian beside it."""
    lanes = LaneMap(
        np.array([0, 2, 4, 6]),
        np.array([LaneKind.ROAD, LaneKind.ROAD, LaneKind.JUNCTION, LaneKind.WALK], dtype=np.uint8),
        np.array([3.2, 3.2, 3.2, 2.0]),
        np.array([-50.0, 20.0, -50.0, 20.0, 20.0, 50.0, -50.0, 50.0]),
        np.array([0.0, 0.0, 3.2, 3.2, 0.0, 0.0, -3.0, -3.0]),
    )
    stage = Stage(np.array([-50.0, 50.0]), np.zeros(2), np.full(2, 13.9))
    objects = ObjectList.of(
        id=[4, 5],
        kind=[ObjectKind.CAR, ObjectKind.PEDESTRIAN],
        x=[15.0, 5.0],
        y=[0.0, -3.0],
        yaw=[0.0, 1.0],
        speed=0.0,
        acceleration=0.0,
        yaw_rate=0.0,
        length=[4.5, 0.5],
        width=[1.8, 0.6],
    )
    repair = Repair(
        Command(0.0, 0.8), RepairStatus.REPAIRED, 0.9, 0.5, 0.4, -0.8, True, 0, (RepairTrigger(4, 1.0),), "car 4 ahead"
    )
    plan = Trajectory(0.5, np.array([4.0, 8.0]), np.zeros(2), np.zeros(2), np.full(2, 8.0))
    route = Route("", 4.8, 1.8, 95.0, 60.0, (stage,), (), (Zone(0, 68.0, 75.0, RightOfWay.STOP),))
    trail = Trail(np.linspace(-30.0, 0.0, 50), np.zeros(50), np.arange(50) > 40)
    ego = EgoState.from_yaw(0.0, 0.0, 0.0, 8.0, 0.0, 4.8, 1.8)
    return SceneView("a car ahead", 2.5, ego, objects, lanes, route, plan, repair, trail, timeline(), "collision")


def pixels_of(figure: Figure) -> Pixels:
    """The figure through PNG and back, shape (rows, columns, 3)."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=80)
    return np.asarray(Image.open(buffer).convert("RGB"))


def share_of(pixels: Pixels, colour: str) -> float:
    """Share of the picture that has a colour."""
    wanted = np.round(np.array(to_rgb(colour)) * 255.0)
    return float((np.abs(pixels - wanted).max(axis=2) <= 2).mean())


def test_everything_is_there_in_its_colour() -> None:
    pixels = pixels_of(draw_scene(view()))
    assert pixels.shape[1] == 800
    assert share_of(pixels, ASPHALT) > 0.02
    for colour in (STATUS_COLOUR[RepairStatus.REPAIRED], KIND_COLOUR[ObjectKind.CAR], TRIGGER_COLOUR):
        assert share_of(pixels, colour) > 0.0003, colour


def test_texts_tell_scenario_time_and_repair() -> None:
    figure = draw_scene(view())
    texts = " | ".join(text.get_text() for text in figure.texts)
    for expected in (
        "a car ahead",
        "t = 2.50 s",
        "collision",
        "score 0.90",
        "threshold 0.50",
        "REPAIRED",
        "car 4 ahead",
    ):
        assert expected in texts
    assert "asked +0.40 → sent \N{MINUS SIGN}0.80" in texts
    assert "trigger 4" in {text.get_text() for text in figure.axes[0].texts}


@pytest.mark.parametrize("text", ["a $b$ c", r"costs $\frac", "$ and $", "$_$"])
def test_a_dollar_in_a_text_from_outside_is_a_dollar(text: str) -> None:
    known = view()
    assert known.repair is not None
    repair = dataclasses.replace(known.repair, reason=text)
    figure = draw_scene(dataclasses.replace(known, scenario=text, outcome=text, repair=repair))
    buffer = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg")
    assert buffer.getvalue().count(f">{text}<") == 2
    assert f">{text}  ·  t = 2.50 s<" in buffer.getvalue()


def test_aspect_is_equal_and_the_crop_as_asked() -> None:
    axes = draw_scene(view(), span=60.0).axes[0]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert right - left == pytest.approx(60.0)
    assert left < 0.0 < right
    assert low < 0.0 < high
    box = axes.get_window_extent()
    assert box.width / (right - left) == pytest.approx(box.height / (high - low), rel=1e-6)


def test_lanes_are_as_wide_as_they_are() -> None:
    bare = dataclasses.replace(
        view(), objects=ObjectList.empty(), route=None, trajectory=None, trail=None, repair=None, timeline=None
    )
    figure = draw_scene(bare, span=40.0)
    pixels = pixels_of(figure)
    column = pixels[:, 200]
    asphalt = (np.abs(column - np.round(np.array(to_rgb(ASPHALT)) * 255.0)).max(axis=1) <= 2).sum()
    metres = asphalt * 40.0 / (figure.axes[0].get_window_extent().width * 80.0 / figure.dpi)
    assert metres == pytest.approx(2 * (3.2 - 0.16), abs=0.25)


def test_a_scene_with_nothing_but_the_ego_is_drawn() -> None:
    lone = SceneView("nothing", 0.0, view().ego, ObjectList.empty())
    assert share_of(pixels_of(draw_scene(lone)), SILENT_COLOUR) > 0.0005


def test_numbers_that_are_not_finite_are_left_out() -> None:
    broken = view()
    broken.objects.x[0] = math.nan
    assert broken.trajectory is not None
    broken.trajectory.x[0] = math.nan
    repair = Repair(Command(0.0, 1.0), RepairStatus.STALE_COMMAND, math.nan, math.nan, math.nan, math.nan, True)
    figure = draw_scene(dataclasses.replace(broken, repair=repair))
    pixels_of(figure)
    texts = " | ".join(text.get_text() for text in figure.texts)
    assert "score" not in texts
    assert "asked none" in texts


@pytest.mark.parametrize("span", [0.0, -1.0, math.nan])
def test_a_span_that_is_none_is_refused(span: float) -> None:
    with pytest.raises(ValueError, match="span"):
        draw_scene(view(), span)


def test_an_ego_that_is_nowhere_is_refused() -> None:
    nowhere = dataclasses.replace(view(), ego=EgoState.from_yaw(math.nan, 0.0, 0.0, 0.0, 0.0, 4.8, 1.8))
    with pytest.raises(ValueError, match="not finite"):
        draw_scene(nowhere)


def test_spans_of_intervention() -> None:
    first, last = timeline().spans()
    assert first == pytest.approx((2.05, 2.95))
    assert last == pytest.approx((9.05, 9.95))


def test_timeline_leaves_out_rows_without_data() -> None:
    full = timeline()
    assert [row.label.partition("\n")[0] for row in rows_of(full)] == ["speed", "gap", "score", "action", "state"]
    none = np.full(len(full.time), math.nan)
    silent = np.full(len(full.time), SILENT)
    without = dataclasses.replace(full, score=none, threshold=none, distance=none, status=silent)
    assert [row.label.partition("\n")[0] for row in rows_of(without)] == ["speed", "action"]
    figure = Figure(figsize=(10, 4))
    assert len(draw_timeline(figure, without, now=3.0)) == 2
    assert len(np.unique(pixels_of(figure).reshape(-1, 3), axis=0)) > 20
    assert rows_of(timeline(1)) == []
    assert draw_timeline(Figure(), timeline(1)) == []


def test_states_are_bands_in_their_colour_and_events_are_named() -> None:
    status = np.repeat([RepairStatus.STARTING, RepairStatus.PASS, SILENT, RepairStatus.PASS], [20, 80, 40, 60])
    events = (Event(0.0, EventKind.STARTED, "go"), Event(5.0, EventKind.WATCHDOG, ""), Event(9.95, EventKind.GOAL, ""))
    course = dataclasses.replace(timeline(), status=status.astype(np.int64), events=events)
    assert course.bands() == [
        Band.of_status(0.0, pytest.approx(1.0), RepairStatus.STARTING),
        Band.of_status(pytest.approx(1.0), pytest.approx(5.0), 0),
        Band.of_status(pytest.approx(5.0), pytest.approx(7.0), SILENT),
        Band.of_status(pytest.approx(7.0), pytest.approx(9.95), 0),
    ]
    figure = Figure(figsize=(10, 5))
    drawn = draw_timeline(figure, course)[-1]
    named = {text.get_text() for text in drawn.texts}
    assert {"starting", "pass", "silent", "watchdog", "goal"} <= named
    assert "started" not in named
    pixels = pixels_of(figure)
    for band in course.bands():
        assert share_of(pixels, band.colour) > 0.002, band.name


def test_interventions_are_drawn_in_the_colour_of_what_they_were() -> None:
    spells = tuple(
        SpellAccount(Spell(begin, 20, 8.0, need), -0.4, None, (), "")
        for begin, need in ((1.0, 1.0), (3.0, 0.0), (5.0, 0.15), (7.0, None))
    )
    course = dataclasses.replace(timeline(), spells=spells)
    figure = Figure(figsize=(10, 5))
    drawn = draw_timeline(figure, course)[-1]
    assert {"spells", "rescue", "nuisance", "unclear", "intervention", "1", "2", "3", "4"} <= {
        drawn.yaxis.get_label().get_text(),
        *(text.get_text() for text in drawn.texts),
    }
    pixels = pixels_of(figure)
    for number, account in enumerate(spells, 1):
        assert share_of(pixels, Band.of_spell(number, account).colour) > 0.001, account.spell.need
    assert [row.label for row in rows_of(timeline())][-1] != "spells"  # nothing to draw without any


def test_the_numbers_of_interventions_never_lie_on_each_other() -> None:
    spells = tuple(SpellAccount(Spell(4.0 + 0.1 * place, 1, 0.4), 0.0, None, (), "") for place in range(30))
    figure = Figure(figsize=(10, 5))
    drawn = draw_timeline(figure, dataclasses.replace(timeline(), spells=spells))[-1]
    figure.canvas.draw()
    frames = [text.get_window_extent() for text in drawn.texts if text.get_text().isdigit()]
    assert 5 <= len(frames) < 30
    assert not any(one.overlaps(other) for one, other in itertools.combinations(frames, 2))


def test_names_of_events_never_lie_on_each_other() -> None:
    events = tuple(Event(4.0 + 0.05 * place, EventKind.WATCHDOG, "") for place in range(30))
    figure = Figure(figsize=(10, 5))
    drawn = draw_timeline(figure, dataclasses.replace(timeline(), events=(*events, Event(9.95, EventKind.GOAL, ""))))[
        -1
    ]
    figure.canvas.draw()
    frames = [text.get_window_extent() for text in drawn.texts if text.get_text() in {"watchdog", "goal"}]
    assert 3 <= len(frames) < 10
    assert not any(one.overlaps(other) for one, other in itertools.combinations(frames, 2))
    assert max(frame.x1 for frame in frames) <= drawn.get_window_extent().x1
