"""What an evaluation is worth: the figures of ``registry.MEASURES``, and the table of them.

Apart from what drives, so that a measure that is added or changed does not make kept episodes stale.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.outcome import EventKind
from roadmend.measures.case_result import CaseResult
from roadmend.measures.evaluation import ALONE, Driven
from roadmend.measures.registry import MEASURES, NETWORK, Column, MethodEpisodes

TITLE = "Policies with and without repair"
_DASH = "\N{EN DASH}"
_INTERVAL = "95 %"


def evaluate(driven: Sequence[Driven]) -> dict[str, dict[str, dict[str, Any]]]:
    """The figures of every method, by policy, method and measure, as plain values.

    A scenario in which the policy alone collides is a violation, one in which it reaches its goal a success: these are
    the cases of the measures, and all scenarios their results.
    """
    return {
        policy: {method: _figures(found, methods[ALONE]) for method, found in methods.items()}
        for policy, methods in _results(driven).items()
        if ALONE in methods
    }


def cases_of(driven: Sequence[Driven]) -> dict[str, dict[str, list[CaseResult]]]:
    """The violations and successes of every policy under every method, in the order in which they were driven."""
    return {
        policy: {method: _cases(found, methods[ALONE]) for method, found in methods.items()}
        for policy, methods in _results(driven).items()
        if ALONE in methods
    }


def _results(driven: Sequence[Driven]) -> dict[str, dict[str, list[EpisodeResult]]]:
    results: dict[str, dict[str, list[EpisodeResult]]] = {}
    for each in driven:
        if each.result is not None:
            results.setdefault(each.trial.policy, {}).setdefault(each.trial.told_as, []).append(each.result)
    return results


def _cases(results: Sequence[EpisodeResult], alone: Sequence[EpisodeResult]) -> list[CaseResult]:
    # Whom others strike without a fault of the policy's has nothing to be repaired, and was not spoilt either.
    violations = {
        before.scenario: before.final.at_fault for before in alone if before.final.at_fault or before.reached_goal
    }
    return [
        CaseResult(result.scenario, "", violations[result.scenario], result)
        for result in results
        if result.scenario in violations
    ]


def _figures(results: Sequence[EpisodeResult], alone: Sequence[EpisodeResult]) -> dict[str, Any]:
    bare = {before.scenario: before for before in alone}
    pairs = [(bare[result.scenario], result) for result in results if result.scenario in bare]
    episodes = MethodEpisodes(results, _cases(results, alone), pairs)
    return {name: measure.figure(episodes) for name, measure in MEASURES.items()}


def evaluation_rows(figures: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> list[list[str]]:
    """The figures as a table, the heading first."""
    columns = [column for measure in MEASURES.values() for column in measure.columns]
    head = ["policy", "repair"]
    for column in columns:
        head += [heading(column), _INTERVAL] if column.interval else [heading(column)]
    rows = [head]
    for policy, methods in figures.items():
        for method, found in methods.items():
            rows.append([policy, method])
            for name, measure in MEASURES.items():
                for column in measure.columns:
                    rows[-1] += _cells(column, found[name])
    return rows


def network_rows(figures: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> list[list[str]]:
    """What comes of driving over a network, as a table, the heading first; shares have counts here, not percent."""
    rows = [["policy", "repair", "egos", "goal", "collisions", *map(heading, NETWORK)]]
    for policy, methods in figures.items():
        for method, found in methods.items():
            outcomes = found["outcomes"]
            counts = (
                found["episodes"],
                outcomes.get(EventKind.GOAL.name, 0),
                outcomes.get(EventKind.COLLISION.name, 0),
            )
            cells = [cell for column in NETWORK for cell in _cells(column, found["network"])]
            rows.append([policy, method, *map(str, counts), *cells])
    return rows


def heading(column: Column) -> str:
    """A column's title and unit."""
    return f"{column.title} [{column.unit}]" if column.unit else column.title


def meanings() -> str:
    """One line about every column."""
    columns = (column for measure in MEASURES.values() for column in measure.columns)
    return "; ".join(
        f"{heading(column)}: {column.meaning}" + (f", {column.better} is better" if column.better else "")
        for column in columns
    )


def _cells(column: Column, figure: Any) -> list[str]:
    value = column.value(figure)
    cells = [_DASH if value is None else f"{value:.{column.digits}f}"]
    if column.interval:
        interval = column.interval(figure)
        cells.append(_DASH if interval is None else f"{interval[0]:.1f} .. {interval[1]:.1f}")
    return cells
