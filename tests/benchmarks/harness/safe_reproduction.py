"""How many crashes happen again, by a judge that knows a record of each, beside controls and the program's own word."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from harness.coded_fields import cross_check
from harness.safe_extraction import groups_of
from roadmend.safe.cases import CrashCase
from roadmend.safe.crash_record import CrashRecord
from roadmend.safe.crash_test_summary import summarise_reproductions
from roadmend.safe.driving import CrashTestResult
from roadmend.safe.judging import JudgedRun, summarise_judged


def measure_reproduction(
    cases: Sequence[CrashCase],
    searched: Sequence[CrashTestResult],
    judged: Sequence[JudgedRun],
    records: Mapping[str, CrashRecord],
    halves: Mapping[str, frozenset[str]],
) -> dict[str, Any]:
    """The figures of one search, by policy; only numbers, no report's content.

    Args:
        cases: all reports.
        searched: what the search came to, every role and policy.
        judged: what the judge says of these.
        records: by case.
        halves: names of the reports in each.
    """
    names = [case.name for case in cases]
    policies = [*dict.fromkeys(result.policy for result in searched)]
    content: dict[str, Any] = {}
    for policy in policies:
        results = [result for result in searched if result.policy == policy]
        runs = [run for run in judged if run.policy == policy]
        own = summarise_reproductions(cases, results)
        content[policy] = {
            **_figures(names, records, runs),
            "by_own_reading": own.reproduced,
            "of_two_vehicles_or_more": own.possible,
            "episodes": own.episodes,
            "by_half": {
                half: _figures(sorted(group), records, [run for run in runs if run.report in group])
                for half, group in groups_of(names, halves).items()
            },
        }
    return content


def _figures(names: Sequence[str], records: Mapping[str, CrashRecord], runs: Sequence[JudgedRun]) -> dict[str, Any]:
    found = asdict(summarise_judged(names, [*records], runs))
    del found["names"]  # which ones is for the report of ``roadmend safe reproduce``
    pairs = found["wrong_records"]
    found["false_accept_rate"] = round(found["wrongly_accepted"] / pairs, 4) if pairs else None
    return found


def measure_records(records: Mapping[str, CrashRecord], reports: Path) -> dict[str, Any]:
    """What the records hold, and how they stand to the coded fields."""
    checks = [check for name, record in records.items() if (check := cross_check(record, reports / name)) is not None]
    return {
        "records": len(records),
        "single_vehicle": sum(not record.collisions for record in records.values()),
        "with_coded_fields": len(checks),
        "statements_compared": sum(check.checked for check in checks),
        "statements_contradicted": sum(len(check.contradicted) for check in checks),
    }
