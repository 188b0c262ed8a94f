"""The reports of ``roadmend safe test`` and ``reproduce``: Markdown, and HTML with pictures beside the sketches."""

import html
from collections.abc import Mapping, Sequence
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.safe.cases import Case
from roadmend.safe.driving import PICTURES, Result
from roadmend.safe.tally import ReproductionTally, TestTally

PAPER_TESTS = (  # the policies of the paper (RQ3): scenarios, violations, first to third violation after how many
    ("paper: IDM", "50", "-", "214", "42", "-", "19.6 %", "1/3/4", "10 to 25"),
    ("paper: PPO", "50", "-", "211", "30", "-", "14.2 %", "-", "10 to 25"),
    ("paper: BeamNG", "50", "-", "96", "87", "-", "90.6 %", "-", "10 to 25"),
    ("paper: LCTGen, IDM", "50", "-", "50", "3", "-", "6.0 %", "-", "-"),
    ("paper: AC3R, BeamNG", "19", "-", "19", "16", "-", "84.2 %", "-", "-"),
)
PAPER_REPRODUCTION = (
    ("paper: IDM", "50", "15", "30.0 %", "-", "-"),
    ("paper: LCTGen, IDM", "50", "3", "6.0 %", "-", "-"),
)
TEST_TITLES = (
    "policy",
    "reports",
    "built",
    "scenarios",
    "collisions",
    "at fault",
    "violation rate",
    "top-1/2/3",
    "seconds per scenario",
)
REPRODUCTION_TITLES = ("policy", "reports", "reproduced", "share", "of those with two vehicles or more", "episodes")
_STYLE = """
:root { color-scheme: light; }
body { margin: 0 auto; max-width: 1180px; padding: 32px 24px; font: 15px/1.5 system-ui, sans-serif; color: #1f2328; }
table { border-collapse: collapse; margin: 12px 0 28px; font-variant-numeric: tabular-nums; }
th, td { padding: 5px 10px; border-bottom: 1px solid #d9dde1; text-align: left; }
section { margin-top: 40px; border-top: 1px solid #d9dde1; padding-top: 8px; }
.row { display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start; }
figure { margin: 0; width: 360px; } figure img { width: 100%; border: 1px solid #d9dde1; }
figcaption { font-size: .85rem; color: #626a72; } .hit { color: #b3361b; font-weight: 600; }
"""


def test_report(
    cases: Sequence[Case], tallies: Mapping[str, TestTally], results: Sequence[Result], out: Path
) -> dict[str, str]:
    """The files of a test report; sketches are copied into the output folder."""
    rows = [(policy, *found.cells()) for policy, found in tallies.items()]
    intro = (
        "Every vehicle of a report took the place of the ego in turn. A violation is a collision, as in the paper; "
        "'at fault' are those that the ego is to blame for by the rules of nuPlan. The paper's figures come from "
        "other simulators and policies."
    )
    return _files("report", "Crash reports as tests", intro, TEST_TITLES, (*rows, *PAPER_TESTS), cases, results, out)


test_report.__test__ = False  # type: ignore[attr-defined]  # for pytest


def reproduction_report(
    cases: Sequence[Case], tallies: Mapping[str, ReproductionTally], results: Sequence[Result], out: Path
) -> dict[str, str]:
    """The files of a reproduction report; sketches are copied into the output folder."""
    rows = [(policy, *found.cells()) for policy, found in tallies.items()]
    intro = (
        "A crash is reproduced if it happens with the policy in the place of at least one of its vehicles: between "
        "the report's vehicles, from its directions, in its manoeuvres, and with the one running into the other "
        "that the report names. The others drive as described and look out for nobody."
    )
    titles = REPRODUCTION_TITLES
    return _files(
        "reproduction", "Crashes reproduced", intro, titles, (*rows, *PAPER_REPRODUCTION), cases, results, out
    )


def table_of(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def _files(
    stem: str,
    title: str,
    intro: str,
    titles: Sequence[str],
    rows: Sequence[Sequence[str]],
    cases: Sequence[Case],
    results: Sequence[Result],
    out: Path,
) -> dict[str, str]:
    own: dict[str, list[Result]] = {case.name: [] for case in cases}
    for result in results:
        own[result.report].append(result)
    listing = [
        (result.report, str(result.vehicle), result.policy, result.scenario or "-", result.text)
        for case in cases
        for result in own[case.name]
    ]
    failed = "".join(f"- {case.name}: {case.problem}\n" for case in cases if case.crash is None)
    markdown = [f"# {title}", intro, table_of(titles, rows)]
    if failed:
        markdown.append(f"Not read:\n\n{failed}")
    markdown.append(table_of(("report", "vehicle", "policy", "scenario", "how it ended"), listing))
    sections = "".join(_section(case, own[case.name], _sketch(case, out)) for case in cases)
    page = (
        f"<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>{html.escape(title)}</title>"
        f"<style>{_STYLE}</style></head><body>\n<h1>{html.escape(title)}</h1>\n<p>{html.escape(intro)}</p>\n"
        f"{_html_table(titles, rows)}\n{sections}</body></html>\n"
    )
    return {f"{stem}.md": "\n\n".join(markdown) + "\n", f"{stem}.html": page}


def _html_table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    return "<table>" + line(titles, "th") + "".join(line(row, "td") for row in rows) + "</table>"


def _section(case: Case, results: Sequence[Result], sketch: str) -> str:
    name = html.escape(case.name)
    if case.crash is None:
        return f"<section><h2>{name}</h2><p>not read: {html.escape(case.problem)}</p></section>\n"
    figures = [_figure(sketch, "the report's sketch", "")] if sketch else []
    words = []
    for result in results:
        who = f"{result.policy} as vehicle {result.vehicle}: "
        hit = " class='hit'" if result.collision else ""
        if result.picture:
            figures.append(_figure(result.picture, who + result.text, hit))
        else:
            words.append(f"<li{hit}>{html.escape(who + result.text)}</li>")
    listed = f"<ul>{''.join(words)}</ul>" if words else ""
    return f"<section><h2>{name}</h2><div class='row'>{''.join(figures)}</div>{listed}</section>\n"


def _figure(source: str, caption: str, attribute: str) -> str:
    text = html.escape(caption)
    return f"<figure><img src='{html.escape(source)}' alt='{text}' loading='lazy'><figcaption{attribute}>{text}</figcaption></figure>"


def _sketch(case: Case, out: Path) -> str:
    """The report's sketch, written beside the pictures; empty where there is none."""
    if case.sketch is None:
        return ""
    name = f"{PICTURES}/sketch-{case.name}.{case.sketch.media_type.rpartition('/')[2]}"
    try:
        (out / PICTURES).mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(case.sketch.data)
    except OSError as error:
        raise InputError(str(out), f"cannot be written ({error.strerror})", "choose a writable folder") from None
    return name
