"""A campaign of faults for a browser: its tables, what their columns mean, and every run beside the undisturbed one."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roadmend.core.whole_file import write_texts
from roadmend.faults.verdict import MEANINGS, Judged
from roadmend.reports.page import render
from roadmend.reports.result_files import origin

_NAME = "faults.html"
_DASH = "\N{EN DASH}"
_RUNS = [
    "fault",
    "clock",
    "seed",
    "exit code",
    "outcome",
    "undisturbed",
    "state after [s]",
    "stands after [s]",
    "nearest [m]",
    "undisturbed [m]",
    "reported in",
    "lost messages",
    "not as it should be",
]


def write_page(
    folder: Path,
    title: str,
    tables: tuple[Sequence[Sequence[str]], Sequence[Sequence[str]]],
    judged: Sequence[Judged],
    file_rows: Sequence[Mapping[str, Any]],
    made: Mapping[str, Any],
) -> Path:
    """Write faults.html, which needs nothing but itself; returns its path.

    Args:
        folder: where.
        title: heading of the page.
        tables: of the graph and of the files, their headings first.
        judged: every run of the graph.
        file_rows: the rows of the files, as plain values.
        made: by what, see ``result_files.provenance``.

    Raises:
        InputError: the folder cannot be written.
    """
    wrong = [
        f"{each.trial.row}, {_clock(each)}, seed {each.trial.seed}: {why}" for each in judged if (why := _why(each))
    ]
    wrong += [f"{row['fault']}: {', '.join(row['faults'])}" for row in file_rows if row["faults"]]
    text = render(
        "faults.html",
        title=title,
        wrong=wrong,
        rows=tables[0] if judged else [],
        meanings=[f"{name}: {meaning}" for name, meaning in MEANINGS.items()],
        files=tables[1],
        runs=[_RUNS, *(_cells(each) for each in judged if each.disturbed.injected)],
        made=origin(made),
    )
    write_texts(folder, {_NAME: text})
    return folder / _NAME


def _cells(each: Judged) -> list[str]:
    """One run."""
    run, evidence, bare = each.disturbed, each.disturbed.evidence, each.undisturbed
    return [
        each.trial.row,
        _clock(each),
        str(each.trial.seed),
        "hung" if run.exit_code is None else str(run.exit_code),
        run.outcome or _DASH,
        bare.outcome if bare and bare.outcome else _DASH,
        _number(evidence.to_state if evidence else None),
        _number(evidence.to_standstill if evidence else None),
        _number(run.distance),
        _number(bare.distance if bare else None),
        ", ".join(_places(each)) or _DASH,
        str(evidence.lost) if evidence else _DASH,
        _why(each),
    ]


def _places(each: Judged) -> list[str]:
    """Where a run told of its fault."""
    fault, evidence = each.trial.fault, each.disturbed.evidence
    if fault is None:
        return []
    places = ["standard error"] if each.disturbed.named else []
    if evidence is not None:
        places += ["bag"] if fault.declared and evidence.is_declared else []
        places += ["diagnostics"] if evidence.in_diagnostics else []
    return places + (["exit code"] if each.disturbed.exit_code else [])


def _why(each: Judged) -> str:
    return ", ".join([*each.faults, *([] if each.is_reported else ["not reported"])])


def _clock(each: Judged) -> str:
    return each.trial.clock if each.trial.clock == "lockstep" else f"{each.trial.clock} x {each.trial.rate:g}"


def _number(value: float | None) -> str:
    return _DASH if value is None else f"{value:.2f}"
