"""One crash report all the way: read, kept, and built into scenarios, step by step for whoever watches."""

from dataclasses import dataclass
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.safe.cases import CrashCase
from roadmend.safe.driving import Task, do
from roadmend.safe.extraction import Extraction, Extractor, Step, Watch
from roadmend.safe.extraction_run import Extracted, keep_extraction
from roadmend.safe.planning import plan
from roadmend.safe.report import CrashReport

MOST_SAMPLES = 1000


@dataclass(frozen=True, slots=True)
class ReportBuild:
    """What became of a report.

    Attributes:
        extraction: what it says, and what of it was not read.
        extracted: the same as it is kept, CASE.json in the folder.
        scenarios: files in the folder.
        problems: why a scenario could not be built, one line each.
    """

    extraction: Extraction
    extracted: Extracted
    scenarios: tuple[str, ...]
    problems: tuple[str, ...]


def build_report(
    report: CrashReport, extractor: Extractor, out: Path, samples: int, seed: int, watch: Watch
) -> ReportBuild:
    """Read a report and build its scenarios: every vehicle of the crash takes the ego's place in turn.

    Args:
        report: to read.
        extractor: reads it.
        out: folder for what is made.
        samples: scenarios of each vehicle; 0 for none.
        seed: of what the report leaves open, and of the simulator.
        watch: called before each step; what it raises ends the work.

    Raises:
        ExtractionError: the report could not be read.
        InputError: there are too many samples, or the folder cannot be written.
    """
    if samples > MOST_SAMPLES:
        raise InputError("samples", f"{samples} is too many", f"ask for at most {MOST_SAMPLES}")
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
        tuple(f"vehicle {result.vehicle}: {result.text}" for result in results if not result.scenario),
    )
