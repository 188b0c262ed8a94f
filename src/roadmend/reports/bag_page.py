"""A page of a recorded episode for a browser: the picture, and under it the values of the tick that is pointed at.

One file that needs nothing else: the picture is inline SVG, the values are JSON, and the script is a few lines.
"""

import math
from typing import Any

from matplotlib.figure import Figure

from roadmend.core.outcome import EventKind
from roadmend.core.spell_account import SpellAccount
from roadmend.measures.need_verdict import verdict_of
from roadmend.recording.episode import BagEpisode
from roadmend.reports.page import inline_svg, render
from roadmend.reports.scene_timeline import VERDICT_COLOUR, Band, Timeline

_INTERVENTIONS_MAX = 10  # that get a button


def page_of(episode: BagEpisode, timeline: Timeline, figure: Figure, now: float) -> str:
    """The text of the page.

    Args:
        episode: what the bag tells.
        timeline: the same, a value a tick.
        figure: the scene with the time line under it, as ``draw_scene`` draws them.
        now: the moment that the scene shows [s].
    """
    return render(
        "bag.html",
        title=figure.texts[0].get_text() if figure.texts else episode.path.stem,
        picture=inline_svg(figure),
        moments=_moments(timeline),
        spells=[_row(number, account) for number, account in enumerate(timeline.spells, 1)],
        is_looked_at=any(account.spell.need is not None for account in timeline.spells),
        account=sorted(episode.account.items()),
        data=_data(episode, timeline, figure, now),
    )


def _moments(timeline: Timeline) -> list[tuple[float, str]]:
    """Times [s] of the longest interventions and of the events, with what happened, for buttons that lead there."""
    longest = sorted(timeline.spans(), key=lambda span: span[0] - span[1])[:_INTERVENTIONS_MAX]
    found = [(begin, f"intervened {begin:.2f} to {end:.2f} s") for begin, end in longest]
    found += [
        (event.time, f"{event.kind.name.lower().replace('_', ' ')} {event.time:.2f} s")
        for event in timeline.events
        if event.kind is not EventKind.STARTED
    ]
    return sorted(found)


def _row(number: int, account: SpellAccount) -> dict[str, Any]:
    """A row of the table of interventions; empty where something is not known."""
    spell, verdict = account.spell, verdict_of(account.spell.need)
    return {
        "number": number,
        "begin": spell.begin,
        "lasts": f"{spell.end - spell.begin:.2f}",
        "dose": f"{spell.dose:.2f}",
        "strongest": f"{account.strongest:+.2f}",
        "worth": "" if account.worth is None else f"{account.worth:+.2f}",
        "need": "" if spell.need is None else f"{spell.need:.2f}",
        "verdict": verdict or "",
        "colour": VERDICT_COLOUR[verdict],
        "who": "; ".join(sight.words for sight in account.chiefly),
        "why": account.why,
    }


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
            for band in [Band.of_status(0.0, 0.0, status)]
        },
        "reason": [known.index(reason) for reason in reasons],
        "reasons": known,
        "events": [[event.time, event.kind.name, event.text] for event in timeline.events],
    }


def _rounded(values: Any, digits: int = 3) -> list[float | None]:
    return [round(value, digits) if math.isfinite(value) else None for value in values.tolist()]
