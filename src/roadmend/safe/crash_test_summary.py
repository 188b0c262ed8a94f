"""What the jobs of many crash reports come to."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from roadmend.safe.cases import CrashCase
from roadmend.safe.driving import CrashTestResult
from roadmend.safe.staging import is_alone


@dataclass(frozen=True, slots=True)
class TestSummary:
    """A policy in the scenarios of crash reports.

    Attributes:
        reports: that were given.
        built: reports of which every vehicle's scenarios could be built and run to their end.
        scenarios: that were run.
        collisions: scenarios in which the ego collided; what the paper counts as a violation.
        at_fault: those of them by the ego's own fault.
        violation_rate: collisions a scenario; None without scenarios.
        top: after how many scenarios, in the order of the reports, the first, second and third collision was seen.
        seconds_per_scenario: mean wall clock of building and driving one; None without scenarios.
    """

    __test__ = False  # for pytest

    reports: int
    built: int
    scenarios: int
    collisions: int
    at_fault: int
    violation_rate: float | None
    top: tuple[int, ...]
    seconds_per_scenario: float | None

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self) | {"top": list(self.top)}

    def cells(self) -> tuple[str, ...]:
        """One row of a table."""
        rate = "-" if self.violation_rate is None else f"{100.0 * self.violation_rate:.1f} %"
        seconds = "-" if self.seconds_per_scenario is None else f"{self.seconds_per_scenario:.2f}"
        top = "/".join(map(str, self.top)) or "-"
        counts = (self.reports, self.built, self.scenarios, self.collisions, self.at_fault)
        return *map(str, counts), rate, top, seconds


def summarise_tests(cases: Sequence[CrashCase], results: Sequence[CrashTestResult]) -> TestSummary:
    """Count the tests of one policy."""
    ran = [(result.driven, result.seconds) for result in results if result.driven is not None]
    hits = [number for number, (driven, _) in enumerate(ran, start=1) if driven.collided]
    return TestSummary(
        reports=len(cases),
        built=sum(_runs_whole(case, results) for case in cases),
        scenarios=len(ran),
        collisions=len(hits),
        at_fault=sum(driven.final.at_fault for driven, _ in ran),
        violation_rate=len(hits) / len(ran) if ran else None,
        top=tuple(hits[:3]),
        seconds_per_scenario=sum(seconds for _, seconds in ran) / len(ran) if ran else None,
    )


def _runs_whole(case: CrashCase, results: Sequence[CrashTestResult]) -> bool:
    own = [result for result in results if result.report == case.name]
    return bool(own) and all(result.driven is not None for result in own)


@dataclass(frozen=True, slots=True)
class ReproductionSummary:
    """The crashes that happened again with a policy in the place of a vehicle, or before its eyes, by the own reading.

    Attributes:
        reports: that were given.
        possible: those with two vehicles or more.
        reproduced: whose crash happened in at least one role of the policy.
        of_possible: those of them with two vehicles or more.
        names: of these.
        episodes: that were driven.
    """

    reports: int
    possible: int
    reproduced: int
    of_possible: int
    names: tuple[str, ...]
    episodes: int

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self) | {"names": list(self.names)}

    def cells(self) -> tuple[str, ...]:
        """One row of a table."""
        return (
            str(self.reports),
            str(self.reproduced),
            _share(self.reproduced, self.reports),
            f"{self.of_possible} of {self.possible} ({_share(self.of_possible, self.possible)})",
            str(self.episodes),
        )


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def summarise_reproductions(cases: Sequence[CrashCase], results: Sequence[CrashTestResult]) -> ReproductionSummary:
    """Count the reproductions of one policy."""
    names = sorted({result.report for result in results if result.reproduced})
    possible = {case.name for case in cases if case.crash is not None and not is_alone(case.crash)}
    episodes = sum(result.episodes for result in results)
    return ReproductionSummary(len(cases), len(possible), len(names), len(possible & {*names}), tuple(names), episodes)
