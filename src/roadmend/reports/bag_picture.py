"""A recorded episode drawn straight from its bag: the scene at a moment and the time line, as a picture or a page."""

import bisect
import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Trajectory
from roadmend.core.errors import InputError
from roadmend.core.geometry import nearest_distance
from roadmend.core.repair import Repair
from roadmend.core.scene import ObjectList
from roadmend.core.spell import Spell
from roadmend.core.spell_account import with_needs
from roadmend.core.whole_file import written_beside
from roadmend.recording.episode import BagEpisode, read_episode
from roadmend.repair.sanitise import usable_plan
from roadmend.reports.bag_page import page_of
from roadmend.reports.scene_layers import Trail
from roadmend.reports.scene_picture import SceneView, draw_scene
from roadmend.reports.scene_timeline import SILENT, Timeline

Floats = NDArray[np.float64]

BEFORE_THE_END_S = 1.0  # [s] the moment shown where nothing was repaired
SLACK_S = 0.5  # [s] by which a moment asked for may lie outside the recording
DPI = 120
_PICTURES = frozenset({".png", ".svg", ".pdf"})
_PAGES = frozenset({".html", ".htm"})


def draw_bag(
    bag: Path,
    out: Path,
    at: float | None = None,
    span: float = 70.0,
    spells: Iterable[Spell] = (),
    read: Callable[[Path], BagEpisode] = read_episode,
) -> float:
    """Draw one moment of a bag into a file.

    Args:
        bag: the bag's folder or its .mcap file.
        out: where to write; .png, .svg, .pdf, or .html for a page that shows each tick's values under the pointer.
        at: simulation time [s]; None picks the middle of the longest intervention, or the last second but one where
            there was none.
        span: width of the scene [m].
        spells: those whose need is known; it shows in their colour, and in the table of a page.
        read: reads the bag.

    Returns:
        Simulation time of the tick that was drawn [s].

    Raises:
        InputError: the bag is unusable, ``at`` lies outside it, or ``out`` cannot be written.
    """
    if out.suffix not in _PICTURES | _PAGES:
        raise InputError(
            str(out), f"{out.suffix or 'no ending'} is no format for a picture", "write .png, .svg, .pdf or .html"
        )
    episode = read(bag)
    timeline = timeline_of(episode, spells)
    stamp = _tick_at(episode, interesting_moment(timeline) if at is None else at)
    view = view_of(episode, stamp, timeline)
    try:
        figure = draw_scene(view, span)
    except ValueError as error:
        raise InputError(str(bag), str(error), "name another moment") from error
    with written_beside(out) as beside:
        if out.suffix in _PAGES:
            beside.write_text(page_of(episode, timeline, figure, view.time), encoding="utf-8")
        else:
            figure.savefig(beside, dpi=DPI, format=out.suffix[1:])
    return view.time


def interesting_moment(timeline: Timeline) -> float:
    """The middle of the longest intervention [s]; without any, a second before the end."""
    spans = timeline.spans()
    if spans:
        begin, end = max(spans, key=lambda span: span[1] - span[0])
        return 0.5 * (begin + end)
    return float(max(timeline.time[-1] - BEFORE_THE_END_S, timeline.time[0]))


def view_of(episode: BagEpisode, stamp: int, timeline: Timeline | None = None) -> SceneView:
    """What a picture of the tick with this stamp [ns] shows."""
    route = episode.route
    return SceneView(
        scenario=route.scenario if route is not None and route.scenario else episode.path.stem,
        time=stamp * 1e-9,
        ego=episode.ego[stamp],
        objects=episode.objects.get(stamp, ObjectList.empty()),
        lanes=episode.lanes,
        route=route,
        trajectory=usable_plan(episode.trajectories.get(stamp, Trajectory.empty())),
        repair=episode.repairs.get(stamp),
        trail=trail_of(episode, stamp),
        timeline=timeline,
        outcome=episode.outcome,
    )


def timeline_of(episode: BagEpisode, spells: Iterable[Spell] = ()) -> Timeline:
    """One value a tick, and the interventions with the needs that ``spells`` tell."""
    stamps = episode.stamps
    repairs = [episode.repairs.get(stamp) for stamp in stamps]
    return Timeline(
        np.array(stamps, dtype=np.float64) * 1e-9,
        np.array([episode.ego[stamp].speed for stamp in stamps]),
        np.array([_distance(episode, stamp) for stamp in stamps]),
        _column(repairs, "score"),
        _column(repairs, "threshold"),
        _column(repairs, "policy_action"),
        _column(repairs, "final_action"),
        np.array([repair is not None and repair.intervened for repair in repairs], dtype=np.bool_),
        np.array([SILENT if repair is None else repair.status for repair in repairs], dtype=np.int64),
        tuple(episode.events),
        with_needs(episode.spells(), spells),
    )


def trail_of(episode: BagEpisode, until: int) -> Trail:
    """The way driven up to a stamp [ns]."""
    stamps = [stamp for stamp in episode.stamps if stamp <= until]
    repairs = [episode.repairs.get(stamp) for stamp in stamps]
    return Trail(
        np.array([episode.ego[stamp].x for stamp in stamps]),
        np.array([episode.ego[stamp].y for stamp in stamps]),
        np.array([repair is not None and repair.intervened for repair in repairs], dtype=np.bool_),
    )


def _distance(episode: BagEpisode, stamp: int) -> float:
    ego, objects = episode.ego[stamp], episode.objects.get(stamp)
    distance = math.inf if objects is None else nearest_distance(ego, objects)
    return distance if math.isfinite(distance) else math.nan


def _column(repairs: list[Repair | None], name: str) -> Floats:
    return np.array([math.nan if repair is None else getattr(repair, name) for repair in repairs], dtype=np.float64)


def _tick_at(episode: BagEpisode, time: float) -> int:
    """Stamp [ns] of the tick nearest to a time [s]."""
    stamps = episode.stamps
    first, last = stamps[0] * 1e-9, stamps[-1] * 1e-9
    if not first - SLACK_S <= time <= last + SLACK_S:
        raise InputError("at", f"{time:g} s is outside the recording", f"name a time from {first:.2f} to {last:.2f} s")
    wanted = round(time * 1e9)
    place = bisect.bisect_left(stamps, wanted)
    near = stamps[max(place - 1, 0) : place + 1]
    return near[int(np.argmin([abs(stamp - wanted) for stamp in near]))]
