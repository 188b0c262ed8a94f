"""An analysis as Markdown for people."""

from collections.abc import Sequence
from statistics import median

from roadmend.core.markdown import table_text
from roadmend.sera.analysis import Analysis
from roadmend.sera.incident import Incident
from roadmend.sera.incident_words import VERDICTS, note_of_incident
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.words import HAZARDS

NOTHING = "No failure and no intervention in these bags."
_DASH = "-"
_NOTE = (
    "Avoidable: how long before contact full braking on the ego's path would last have kept the two apart, median over "
    "the incidents; an estimate, since the other is taken to drive as it was recorded. Needed: interventions at whose "
    "beginning the policy's plan came within 1 m of somebody as recorded; also an estimate, since they have seen the "
    "repaired ego."
)


def pattern_rows(analysis: Analysis) -> list[tuple[str, ...]]:
    """One row a pattern, the heading first."""
    rows: list[tuple[str, ...]] = [("pattern", "incidents", "bags", "hazard", "the ego's fault", "avoidable", "repair")]
    incidents = {(one.bag, one.time, one.kind == "intervention"): one for one in analysis.incidents}
    for pattern in analysis.patterns:
        shown = [incidents[each.episode, each.time or 0.0, pattern.what is None] for each in pattern.evidence]
        rows.append(
            (
                pattern.words,
                str(len(shown)),
                str(len({one.bag for one in shown})),
                _DASH if pattern.why.hazard is None else HAZARDS[pattern.why.hazard],
                _fault(shown),
                _avoidable(shown),
                _verdicts(shown),
            )
        )
    return rows


def report(analysis: Analysis) -> str:
    """The table of the patterns, the evidence of each, and the bags that could not be read."""
    count = len(analysis.bags)
    read = f"{count} bag{'' if count == 1 else 's'} read, {len(analysis.incidents)} incidents"
    lines = [
        "# Failure patterns",
        "",
        f"{read}, {len(analysis.patterns)} patterns (analyser: {analysis.analyser}).",
        "",
    ]
    if analysis.patterns:
        lines += [table_text(pattern_rows(analysis)), "", _NOTE, ""]
    else:
        lines += [NOTHING, ""]
    incidents = {(one.bag, one.time, one.kind == "intervention"): one for one in analysis.incidents}
    for pattern in analysis.patterns:
        lines += [f"## {pattern.words}", "", *_conditions(pattern)]
        for each in pattern.evidence:
            one = incidents[each.episode, each.time or 0.0, pattern.what is None]
            lines.append(f"- `{one.bag}` at {one.time:.2f} s: {_sentence(one)}")
        lines.append("")
    if analysis.unreadable:
        lines += ["## Not read", "", *(f"- {each.problem}" for each in analysis.unreadable), ""]
    return "\n".join(lines)


def _sentence(one: Incident) -> str:
    other = "" if one.other is None else f", {one.other.name or one.other.kind} at {one.other.speed:.1f} m/s"
    manner = f"{one.manner}, " if one.manner else ""
    return f"{manner}ego at {one.ego.speed:.1f} m/s{other}; {note_of_incident(one)}"


def _conditions(pattern: FailurePattern) -> list[str]:
    where = pattern.where
    shared = [
        *([f"family {where.family}"] if where.family else []),
        *([where.road.replace("_", " ")] if where.road else []),
        *([where.control.replace("_", " ")] if where.control else []),
        *([f"{where.density} traffic"] if where.density else []),
        *([where.weather] if where.weather else []),
        *([where.light] if where.light else []),
        *([f"{pattern.who.driver} driver"] if pattern.who.driver else []),
    ]
    return [f"Common to all: {', '.join(shared)}.", ""] if shared and len(pattern.evidence) > 1 else []


def _fault(incidents: Sequence[Incident]) -> str:
    told = [one.at_fault for one in incidents if one.at_fault is not None]
    return f"{sum(told)} of {len(told)}" if told else _DASH


def _avoidable(incidents: Sequence[Incident]) -> str:
    collisions = [one for one in incidents if one.kind == "collision"]
    if not collisions:
        return _DASH
    known = [one.avoidable for one in collisions if one.avoidable is not None]
    if not known:
        return "never"
    text = f"{median(known):.2f} s"
    return text if len(known) == len(collisions) else f"{text} ({len(known)} of {len(collisions)})"


def _verdicts(incidents: Sequence[Incident]) -> str:
    counts: dict[str, int] = {}
    for one in incidents:
        counts[VERDICTS[one.repair.verdict]] = counts.get(VERDICTS[one.repair.verdict], 0) + 1
    return "; ".join(
        f"{count} x {text}" for text, count in sorted(counts.items(), key=lambda each: (-each[1], each[0]))
    )
