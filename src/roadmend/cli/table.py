"""Results of runs as a table for people."""

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from roadmend.nodes.launcher import RunResult

_STYLES = {"GOAL": "green", "COLLISION": "red", "TIMEOUT": "yellow", "OFF_ROUTE": "yellow", "ABORTED": "yellow"}


def show_results(results: Sequence[RunResult], console: Console) -> None:
    """Print one row a run."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("scenario", "method", "outcome"):
        table.add_column(title)
    for title in ("min distance", "interventions", "intensity", "real-time factor"):
        table.add_column(title, justify="right")
    table.add_column("bag", overflow="fold")
    for result in results:
        distance = "-" if result.min_distance is None else f"{result.min_distance:.2f} m"
        table.add_row(
            result.scenario,
            result.method,
            f"[{_STYLES.get(result.outcome, 'white')}]{result.outcome}[/]",
            distance,
            str(result.interventions),
            f"{result.intensity:.2f}" if result.interventions else "-",
            f"{result.real_time_factor:.1f} x",
            result.bag or "-",
        )
    console.print(table)
