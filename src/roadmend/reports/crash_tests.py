"""The reports of ``roadmend safe test`` and ``reproduce``: Markdown, HTML, and the pictures in it beside the sketches."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from roadmend.core.markdown import table_text
from roadmend.core.tick import INTERVAL
from roadmend.core.whole_file import written_beside
from roadmend.reports.crash_film import film_beside, film_of_trial, load_film, save_film
from roadmend.reports.crash_page import SHOWN, account_of_case, page_of_crash
from roadmend.reports.page import render
from roadmend.reports.scene_layers import Trail
from roadmend.reports.scene_picture import SceneView, draw_scene
from roadmend.safe.cases import CrashCase
from roadmend.safe.crash_test_summary import ReproductionSummary, TestSummary
from roadmend.safe.driving import PICTURES, CrashTestResult
from roadmend.safe.judging import JudgedRun, JudgedSummary, summarise_judged
from roadmend.safe.trial import CrashTestEpisode
from roadmend.world.network import network_file
from roadmend.world.road_network import lanes_of, read_network
from roadmend.world.scenario import Scenario

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
JUDGED_TITLES = (
    "policy",
    "reports",
    "run",
    "reproduced",
    "share",
    "only with the policy standing",
    "with the policy looking on",
    "collisions shown",
    "unphysical runs",
    "wrong records accepted",
)
JUDGED_RUN_TITLES = ("report", "vehicle", "policy", "by the record", "what differs")
PAGES = "pages"  # folder in the output
_DPI, _SPAN = 72, 60.0  # of a picture; [m] that it shows
REPRODUCTION_TITLES = ("policy", "reports", "reproduced", "share", "of those with two vehicles or more", "episodes")


def draw_trial(scenario: Scenario, trial: CrashTestEpisode, out: Path) -> None:
    """Draw a built scenario at the ego's contact, else when it was nearest to somebody, into a PNG file; its run beside it.

    Raises:
        InputError: the file cannot be written.
    """
    tick = trial.moment
    contact = next((each for each in trial.run.contacts if each.tick == tick), None)
    before = trial.film.ego[: tick + 1]
    view = SceneView(
        scenario=scenario.name,
        time=tick * INTERVAL,
        ego=trial.film.ego[tick],
        objects=trial.film.objects[tick],
        lanes=lanes_of(read_network(network_file(scenario.network))),
        route=trial.route,
        trail=Trail(
            np.array([ego.x for ego in before]), np.array([ego.y for ego in before]), np.zeros(len(before), np.bool_)
        ),
        mark=None if contact is None else (contact.x, contact.y),
        outcome=trial.summary.outcome.name.lower().replace("_", " "),
    )
    with written_beside(out) as beside:
        draw_scene(view, _SPAN).savefig(beside, dpi=_DPI, format="png")
    save_film(film_of_trial(scenario, trial), film_beside(out))


def report_of_tests(
    cases: Sequence[CrashCase], tallies: Mapping[str, TestSummary], results: Sequence[CrashTestResult], out: Path
) -> dict[str, str]:
    """The files of a test report, a page of each case among them; sketches are copied into the output folder."""
    rows = [(policy, *found.cells()) for policy, found in tallies.items()]
    intro = (
        "Every vehicle of a report took the place of the ego in turn; where one crashes alone, the ego looks on. A "
        "violation is a collision, as in the paper; "
        "'at fault' are those that the ego is to blame for by the rules of nuPlan. The paper's figures come from "
        "other simulators and policies."
    )
    return _files("report", "Crash reports as tests", intro, (TEST_TITLES, *rows, *PAPER_TESTS), cases, results, out)


def report_of_reproductions(
    cases: Sequence[CrashCase],
    tallies: Mapping[str, ReproductionSummary],
    results: Sequence[CrashTestResult],
    out: Path,
    judged: Sequence[JudgedRun] = (),
) -> dict[str, str]:
    """The files of a reproduction report, a page of each case among them; sketches are copied into the folder.

    Args:
        cases: that were given.
        tallies: by policy, by the program's own reading.
        results: of all roles.
        out: the output folder.
        judged: what the judge says of the results, where records were given.
    """
    rows = [(policy, *found.cells()) for policy, found in tallies.items()]
    intro = (
        "A crash is reproduced if it happens with the policy in the place of at least one of its vehicles: between "
        "the same two, the same one running into the other, on the same parts, from and to the same directions, on the "
        "same type of road, everybody moving as vehicles can. The first table goes by this program's own reading of "
        "the report; the second, where records were given, by a record of the real crash that no reading touches. "
        "The others drive as described and look out for nobody. Where one vehicle crashes alone, the policy looks on."
    )
    table = (REPRODUCTION_TITLES, *rows, *PAPER_REPRODUCTION)
    by_record: list[Sequence[Sequence[str]]] = []
    if judged:
        recorded = [run.report for run in judged if run.failed is not None]
        rows = [
            (policy, *judged_cells(summarise_judged([case.name for case in cases], recorded, _of(judged, policy))))
            for policy in tallies
        ]
        by_record = [(JUDGED_TITLES, *rows), (JUDGED_RUN_TITLES, *map(_judged_row, judged))]
    files = _files("reproduction", "Crashes reproduced", intro, table, cases, results, out, by_record)
    if judged:
        tables = map(table_text, by_record)
        files["reproduction.md"] += "\n" + "\n\n".join(["## By the records", *tables]) + "\n"
        files["judged.json"] = json.dumps([asdict(run) for run in judged], indent=1) + "\n"
    return files


def judged_cells(found: JudgedSummary) -> tuple[str, ...]:
    """One row of the table of what the judge says."""
    share = f"{100.0 * found.reproduced / found.reports:.1f} %" if found.reports else "-"
    wrong = f"{found.wrongly_accepted} of {found.wrong_records}"
    counts = (found.reports, found.run, found.reproduced)
    return (
        *map(str, counts),
        share,
        str(found.stood),
        str(found.looked_on),
        f"{found.shown} of {found.collisions}",
        str(found.unphysical),
        wrong,
    )


def _judged_row(run: JudgedRun) -> tuple[str, ...]:
    if run.failed is None:
        return run.report, _role(run.vehicle), run.policy, "-", run.note
    verdict = "reproduced" if run.is_reproduced else ", ".join(run.failed)
    return run.report, _role(run.vehicle), run.policy, verdict, run.note


def _role(vehicle: int | None) -> str:
    return "onlooker" if vehicle is None else str(vehicle)


def _of(judged: Sequence[JudgedRun], policy: str) -> list[JudgedRun]:
    return [run for run in judged if run.policy == policy]


def _files(
    stem: str,
    title: str,
    intro: str,
    table: Sequence[Sequence[str]],
    cases: Sequence[CrashCase],
    results: Sequence[CrashTestResult],
    out: Path,
    by_record: Sequence[Sequence[Sequence[str]]] = (),
) -> dict[str, str]:
    own: dict[str, list[CrashTestResult]] = {case.name: [] for case in cases}
    for result in results:
        own[result.report].append(result)
    listing = [("report", "vehicle", "policy", "scenario", "how it ended")] + [
        (result.report, _role(result.vehicle), result.policy, result.scenario or "-", result.text)
        for case in cases
        for result in own[case.name]
    ]
    failed = "".join(f"- {case.name}: {case.problem}\n" for case in cases if case.crash is None)
    markdown = [f"# {title}", intro, table_text(table)]
    if failed:
        markdown.append(f"Not read:\n\n{failed}")
    markdown.append(table_text(listing))
    page = render(
        "crash_tests.html",
        title=title,
        intro=intro,
        head=table[0],
        rows=table[1:],
        by_record=[(each[0], each[1:]) for each in by_record],
        cases=[(case, _sketch(case, out), own[case.name], f"{PAGES}/{case.name}.html") for case in cases],
    )
    pages = {
        f"{PAGES}/{case.name}.html": page_of_crash(account_of_case(case, _films(own[case.name], out)))
        for case in cases
        if case.crash is not None
    }
    return {f"{stem}.md": "\n\n".join(markdown) + "\n", f"{stem}.html": page, **pages}


def _films(results: Sequence[CrashTestResult], out: Path) -> list[dict[str, Any]]:
    films = (load_film(film_beside(out / result.picture)) for result in results if result.picture)
    return [film for film in films if film is not None]


def _sketch(case: CrashCase, out: Path) -> str:
    """The report's sketch, written beside the pictures; empty where there is none that a browser can show."""
    if case.sketch is None or case.sketch.media_type not in SHOWN:
        return ""
    name = f"{PICTURES}/sketch-{case.name}.{case.sketch.media_type.rpartition('/')[2]}"
    with written_beside(out / name) as beside:
        beside.write_bytes(case.sketch.data)
    return name
