"""The reports of ``roadmend safe test`` and ``reproduce``: Markdown, HTML, and the pictures in it beside the sketches."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from roadmend.core.errors import InputError
from roadmend.core.markdown import table_text
from roadmend.core.tick import INTERVAL
from roadmend.core.whole_file import written_beside
from roadmend.reports.crash_film import film_beside, film_of_trial, load_film, save_film
from roadmend.reports.crash_page import account_of_case, page_of_crash
from roadmend.reports.page import render
from roadmend.reports.scene_layers import Trail
from roadmend.reports.scene_picture import SceneView, draw_scene
from roadmend.safe.cases import CrashCase
from roadmend.safe.crash_test_summary import ReproductionSummary, TestSummary
from roadmend.safe.driving import PICTURES, CrashTestResult
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
PAGES = "pages"  # folder in the output
_DPI, _SPAN = 72, 90.0  # of a picture; [m] that it shows
REPRODUCTION_TITLES = ("policy", "reports", "reproduced", "share", "of those with two vehicles or more", "episodes")


def draw_trial(scenario: Scenario, trial: CrashTestEpisode, out: Path) -> None:
    """Draw a built scenario, at the moment when the ego was nearest to somebody, into a PNG file; its run beside it.

    Raises:
        InputError: the file cannot be written.
    """
    tick = trial.film.nearest()
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
        "Every vehicle of a report took the place of the ego in turn. A violation is a collision, as in the paper; "
        "'at fault' are those that the ego is to blame for by the rules of nuPlan. The paper's figures come from "
        "other simulators and policies."
    )
    return _files("report", "Crash reports as tests", intro, (TEST_TITLES, *rows, *PAPER_TESTS), cases, results, out)


def report_of_reproductions(
    cases: Sequence[CrashCase],
    tallies: Mapping[str, ReproductionSummary],
    results: Sequence[CrashTestResult],
    out: Path,
) -> dict[str, str]:
    """The files of a reproduction report, a page of each case among them; sketches are copied into the folder."""
    rows = [(policy, *found.cells()) for policy, found in tallies.items()]
    intro = (
        "A crash is reproduced if it happens with the policy in the place of at least one of its vehicles: between "
        "the report's vehicles, from its directions, in its manoeuvres, and with the one running into the other "
        "that the report names. The others drive as described and look out for nobody."
    )
    table = (REPRODUCTION_TITLES, *rows, *PAPER_REPRODUCTION)
    return _files("reproduction", "Crashes reproduced", intro, table, cases, results, out)


def _files(
    stem: str,
    title: str,
    intro: str,
    table: Sequence[Sequence[str]],
    cases: Sequence[CrashCase],
    results: Sequence[CrashTestResult],
    out: Path,
) -> dict[str, str]:
    own: dict[str, list[CrashTestResult]] = {case.name: [] for case in cases}
    for result in results:
        own[result.report].append(result)
    listing = [("report", "vehicle", "policy", "scenario", "how it ended")] + [
        (result.report, str(result.vehicle), result.policy, result.scenario or "-", result.text)
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
