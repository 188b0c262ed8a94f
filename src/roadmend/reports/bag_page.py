"""A page of a recorded episode for a browser: the picture, and under it the values of the tick that is pointed at.

One file that needs nothing else: the picture is inline SVG, the values are JSON, and the script is a few lines.
"""

import html
import io
import json
import math
from importlib.resources import files
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from roadmend.core.outcome import EventKind
from roadmend.recording.episode import BagEpisode
from roadmend.reports.scene_timeline import Band, Timeline

_TEMPLATE = "bag_page.html"
_INTERVENTIONS_MAX = 10  # that get a button


def page_of(episode: BagEpisode, timeline: Timeline, figure: Figure, now: float) -> str:
    """The text of the page.

    Args:
        episode: what the bag tells.
        timeline: the same, a value a tick.
        figure: the scene with the time line under it, as ``draw_scene`` draws them.
        now: the moment that the scene shows [s].
    """
    title = figure.texts[0].get_text() if figure.texts else episode.path.stem
    parts = {
        "TITLE": html.escape(title),
        "PICTURE": _svg_of(figure),
        "MOMENTS": _moments(timeline),
        "ACCOUNT": "\n".join(
            f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
            for name, value in sorted(episode.account.items())
        ),
        "DATA": _json_of(_data(episode, timeline, figure, now)),
    }
    page = files("roadmend.reports").joinpath(_TEMPLATE).read_text(encoding="utf-8")
    # Part by part from the left: what is put in may hold anything, the name of another part too.
    pieces = page.split("@@")
    return "".join(parts[piece] if place % 2 else piece for place, piece in enumerate(pieces))


def _svg_of(figure: Figure) -> str:
    # Texts stay texts, and equal pictures are equal to the byte.
    with io.StringIO() as buffer, mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "roadmend"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
        text = buffer.getvalue()
    return text[text.index("<svg") :]  # without the XML declaration, which has no place inside a page


def _moments(timeline: Timeline) -> str:
    """Buttons that lead to the longest interventions and to the events."""
    longest = sorted(timeline.spans(), key=lambda span: span[0] - span[1])[:_INTERVENTIONS_MAX]
    found = [(begin, f"intervened {begin:.2f} to {end:.2f} s") for begin, end in longest]
    found += [
        (event.time, f"{event.kind.name.lower().replace('_', ' ')} {event.time:.2f} s")
        for event in timeline.events
        if event.kind is not EventKind.STARTED
    ]
    return "\n".join(
        f'<button type="button" data-time="{time:.6f}">{html.escape(text)}</button>' for time, text in sorted(found)
    )


def _data(episode: BagEpisode, timeline: Timeline, figure: Figure, now: float) -> dict[str, Any]:
    repairs = [episode.repairs.get(stamp) for stamp in episode.stamps]
    reasons = ["" if repair is None else repair.reason for repair in repairs]
    known = list(dict.fromkeys(reasons))
    boxes = [axes.get_position() for axes in figure.axes[1:]]  # of the time line, as shares of the picture
    return {
        "now": now,
        "box": [boxes[0].x0, boxes[0].x1, 1.0 - boxes[0].y1, 1.0 - boxes[-1].y0] if boxes else None,
        "time": _rounded(timeline.time, 6),
        "speed": _rounded(timeline.speed),
        "gap": _rounded(timeline.distance),
        "score": _rounded(timeline.score),
        "threshold": _rounded(timeline.threshold),
        "asked": _rounded(timeline.policy_action),
        "sent": _rounded(timeline.final_action),
        "intervened": timeline.intervened.astype(int).tolist(),
        "state": timeline.status.tolist(),
        "states": {
            status: [band.name, band.colour]
            for status in sorted(set(timeline.status.tolist()))
            for band in [Band(0.0, 0.0, status)]
        },
        "reason": [known.index(reason) for reason in reasons],
        "reasons": known,
        "events": [[event.time, event.kind.name, event.text] for event in timeline.events],
    }


def _rounded(values: Any, digits: int = 3) -> list[float | None]:
    return [round(value, digits) if math.isfinite(value) else None for value in values.tolist()]


def _json_of(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element that it stands in."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
