"""The pages of reports that were extracted into a folder: each beside its scenario, with the scene as it is built."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from roadmend.core.errors import RoadmendError
from roadmend.core.whole_file import write_text
from roadmend.reports.crash_film import film_of_start
from roadmend.reports.crash_page import account_of_extraction, load_account, page_of_crash
from roadmend.safe.construction import draw_scenario, roles_of
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.dsl_file import load_crash_scenario
from roadmend.safe.extraction import Extraction
from roadmend.safe.report import CrashReport, load_report


def write_crash_pages(reports: Sequence[Path], out: Path) -> list[Path]:
    """Write CASE.html for each report of which the folder holds the extraction.

    Args:
        reports: paths of the reports.
        out: folder that ``extract_reports`` wrote to.

    Raises:
        InputError: a report or its extraction cannot be read, or the folder not be written.
    """
    written = []
    for path in reports:
        report = load_report(path)
        crash = load_crash_scenario(out / f"{report.case}.json")
        page = out / f"{report.case}.html"
        write_text(page, page_of_crash(load_account(report, out, _start_of(report.case, crash))))
        written.append(page)
    return written


def write_crash_page(report: CrashReport, extraction: Extraction, out: Path) -> Path:
    """Write CASE.html of a report that was just read, with its scenes as they are built.

    Raises:
        InputError: the folder cannot be written.
    """
    films = _start_of(report.case, extraction.scenario)
    page = out / f"{report.case}.html"
    write_text(
        page, page_of_crash(account_of_extraction(report.case, report.summary, report.sketch, extraction, films))
    )
    return page


def _start_of(case: str, crash: CrashScenario) -> list[dict[str, Any]]:
    """The scene with the policy in each role that can be built; a page has more than its scenes."""
    films = []
    for role in roles_of(case, crash):
        try:
            films.append(film_of_start(draw_scenario(role, 0)))
        except RoadmendError:
            continue
    return films
