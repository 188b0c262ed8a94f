"""The reports of ``roadmend safe test`` and ``reproduce``: Markdown, and HTML with pictures beside the sketches."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.reports.markdown import table_text
from roadmend.reports.page import render
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


def report_of_tests(
    cases: Sequence[Case], tallies: Mapping[str, TestTally], results: Sequence[Result], out: Path
) -> dict[str, str]:
    """The files of a test report; sketches are copied into the output folder."""
    rows = [(policy, *found.cells()) for policy, found in tallies.items()]
    intro = (
        "Every vehicle of a report took the place of the ego in turn. A violation is a collision, as in the paper; "
        "'at fault' are those that the ego is to blame for by the rules of nuPlan. The paper's figures come from "
        "other simulators and policies."
    )
    return _files("report", "Crash reports as tests", intro, (TEST_TITLES, *rows, *PAPER_TESTS), cases, results, out)


def report_of_reproductions(
    cases: Sequence[Case], tallies: Mapping[str, ReproductionTally], results: Sequence[Result], out: Path
) -> dict[str, str]:
    """The files of a reproduction report; sketches are copied into the output folder."""
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
    cases: Sequence[Case],
    results: Sequence[Result],
    out: Path,
) -> dict[str, str]:
    own: dict[str, list[Result]] = {case.name: [] for case in cases}
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
        cases=[(case, _sketch(case, out), own[case.name]) for case in cases],
    )
    return {f"{stem}.md": "\n\n".join(markdown) + "\n", f"{stem}.html": page}


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
