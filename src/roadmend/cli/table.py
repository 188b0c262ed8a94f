"""Results of runs as a table for people."""

import sys
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from roadmend.nodes.launcher import RunResult

OUTCOME_STYLES = {"GOAL": "green", "COLLISION": "red", "TIMEOUT": "yellow", "OFF_ROUTE": "yellow", "ABORTED": "yellow"}


def wide_console() -> Console:
    """Standard output: as wide as the terminal, and wide enough for any row where there is none."""
    return Console(width=None if sys.stdout.isatty() else 200)


def show_rows(rows: Sequence[Sequence[str]]) -> None:
    """Print a table; the first row is the heading."""
    table = Table(*rows[0], box=None, pad_edge=False, header_style="bold")
    for row in rows[1:]:
        table.add_row(*row)
    wide_console().print(table)


def show_results(results: Sequence[RunResult], console: Console) -> None:
    """Print one row a run."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("scenario", "method", "outcome"):
        table.add_column(title, no_wrap=True)
    for title in ("min\ndistance", "inter-\nventions", "intensity", "real-time\nfactor"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("bag", overflow="fold")
    for result in results:
        distance = "-" if result.min_distance is None else f"{result.min_distance:.2f} m"
        table.add_row(
            result.scenario,
            result.method,
            f"[{OUTCOME_STYLES.get(result.outcome, 'white')}]{result.outcome}[/]",
            distance,
            str(result.interventions),
            f"{result.intensity:.2f}" if result.interventions else "-",
            f"{result.real_time_factor:.1f} x",
            result.bag or "-",
        )
    console.print(table)
