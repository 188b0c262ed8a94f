"""One crash report all the way: read, kept, and built into scenarios, step by step for whoever watches."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from roadmend.core.errors import InputError
from roadmend.core.registry import Registry
from roadmend.safe.cases import CrashCase
from roadmend.safe.construction import role_title
from roadmend.safe.driving import Task, do
from roadmend.safe.extraction import Extraction, Extractor, Step, Watch
from roadmend.safe.extraction_run import Extracted, check_own, keep_extraction
from roadmend.safe.planning import plan
from roadmend.safe.report import CrashReport

MOST_SAMPLES = 1000

WritePage = Callable[[CrashReport, Extraction, Path], Path]  # of a report that was read, into a folder; gives its file


def _of_function(given: str, thing: Any) -> WritePage | None:
    if not callable(thing):
        raise InputError(f"page {given}", "cannot be called", "name a function of report, extraction and folder")
    return cast("WritePage", thing)


# The page is made in a room above, which whoever runs the work names.
PAGE_REGISTRY: Registry[WritePage | None] = Registry("page", "roadmend.crash_pages", {"none": None}, _of_function)


@dataclass(frozen=True, slots=True)
class ReportBuild:
    """What became of a report.

    Attributes:
        extraction: what it says, and what of it was not read.
        extracted: the same as it is kept, CASE.json in the folder.
        scenarios: files in the folder.
        problems: why a scenario could not be built, one line each.
        page: file of the page; None where none was wanted.
    """

    extraction: Extraction
    extracted: Extracted
    scenarios: tuple[str, ...]
    problems: tuple[str, ...]
    page: Path | None = None


def build_report(
    report: CrashReport,
    extractor: Extractor,
    out: Path,
    samples: int,
    seed: int,
    watch: Watch,
    write_page: WritePage | None = None,
) -> ReportBuild:
    """Read a report and build its scenarios: every vehicle of the crash takes the ego's place in turn.

    Args:
        report: to read.
        extractor: reads it.
        out: folder for what is made.
        samples: scenarios of each vehicle; 0 for none.
        seed: of what the report leaves open, and of the simulator.
        watch: called before each step; what it raises ends the work.
        write_page: writes the page of the report, last of all; None for no page.

    Raises:
        ExtractionError: the report could not be read.
        InputError: there are too many samples, the folder cannot be written, or it holds a scenario of the report's
            name that no call wrote or that was changed since.
    """
    if samples > MOST_SAMPLES:
        raise InputError("samples", f"{samples} is too many", f"ask for at most {MOST_SAMPLES}")
    check_own(out, report.case, f"the report {report.case!r}")
    extraction = extractor.extract(report, watch)
    extracted = keep_extraction(extraction, report.case, report.digest(), out)
    jobs = plan(Task.BUILD, [CrashCase(report.case, extraction.scenario)], [""], out, samples=samples, seed=seed)
    results = []
    for number, job in enumerate(jobs, start=1):
        watch(Step("build", number, len(jobs)))
        results.append(do(job))
    return ReportBuild(
        extraction,
        extracted,
        tuple(result.scenario for result in results if result.scenario),
        tuple(f"{role_title(result.vehicle)}: {result.text}" for result in results if not result.scenario),
        write_page(report, extraction, out) if write_page is not None else None,
    )
