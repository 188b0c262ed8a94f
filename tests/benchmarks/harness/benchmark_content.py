"""The benchmark of repair methods as one tree of plain values: what is written as JSON and drawn from."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from harness.benchmark_run import HINDSIGHT, Measured
from harness.paper_figures import PAPER
from roadmend.measures.case_result import CaseResult
from roadmend.measures.monitor import summarise_monitor
from roadmend.measures.repair import advantage, share_of_bound, summarise
from roadmend.world.case_name import search_of
from roadmend.world.families import FAMILIES

FORMAT = "roadmend-repair-benchmark/1"
OURS = "adreft"
_LETTERS = {"GOAL": "G", "COLLISION": "C", "TIMEOUT": "T", "OFF_ROUTE": "O", "ABORTED": "A"}


def build_content(measured: Sequence[Measured], made: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Everything but cost and robustness, which are measured by others.

    Args:
        measured: a policy each.
        made: provenance.
        settings: what was asked for.
    """
    policies = [each.benchmark.policy for each in measured]
    families = [name for name in FAMILIES if any(case.family == name for m in measured for case in m.benchmark.cases)]
    content: dict[str, Any] = {
        "format": FORMAT,
        "provenance": made,
        "settings": settings,
        "policies": policies,
        "corpora": {each.benchmark.policy: _corpus(each) for each in measured},
        "titles": {c.name: {"title": c.title, "group": c.group} for m in measured for c in m.benchmark.contenders},
        "monitor_titles": {monitor.name: monitor.title for m in measured for monitor in m.benchmark.monitors},
        "contenders": {
            each.benchmark.policy: {contender.name: contender.describe() for contender in each.benchmark.contenders}
            for each in measured
        },
        "not_run": [
            {"policy": absence.policy, "method": absence.name, "reason": absence.reason}
            for each in measured
            for absence in each.benchmark.absences
        ],
        "summary": {each.benchmark.policy: _summaries(each) for each in measured},
        "families": {
            family: {each.benchmark.policy: _family(each, family) for each in measured} for family in families
        },
        "monitor": {
            each.benchmark.policy: {
                name: summarise_monitor(episodes, [search_of(case.name) for case in each.benchmark.cases])
                for name, episodes in each.confusions.items()
            }
            for each in measured
        },
        "cost": {},
        "robustness": None,
        "paper": PAPER,
    }
    return content


def case_table(measured: Sequence[Measured]) -> dict[str, Any]:
    """What every case came to under every method, a column each; the order is that of ``names``.

    ``outcomes`` has a letter a case: G goal, C collision, T time limit, O off the route, A aborted. ``digests`` are the
    first 12 hexadecimal digits of the trajectories'.
    """
    return {
        each.benchmark.policy: {
            "names": [case.name for case in each.benchmark.cases],
            "families": [case.family for case in each.benchmark.cases],
            "alone": "".join("C" if case.is_violation else "G" for case in each.benchmark.cases),
            "methods": {
                method: {
                    "outcomes": "".join(_LETTERS[result.episode.outcome.name] for result in results),
                    "frames": [result.episode.interventions for result in results],
                    "doses": [round(result.episode.dose, 4) for result in results],
                    "digests": [result.episode.digest[:12] for result in results],
                }
                for method, results in each.results.items()
            },
        }
        for each in measured
    }


@dataclass(frozen=True, slots=True)
class Difference:
    """Where two case tables do not say the same."""

    text: str
    ends_otherwise: bool = False  # whether an episode has another outcome, not only another way there


def differences(fresh: Mapping[str, Any], kept: Mapping[str, Any]) -> list[Difference]:
    """Where two case tables differ; only what is in the fresh one is looked at."""
    found: list[Difference] = []
    for policy, table in fresh.items():
        before = kept.get(policy)
        if before is None:
            found.append(Difference(f"policy {policy} is not in the committed table"))
            continue
        places = {name: place for place, name in enumerate(before["names"])}
        for method, columns in table["methods"].items():
            if method not in before["methods"]:
                found.append(Difference(f"{policy}, {method}: is not in the committed table"))
                continue
            then = before["methods"][method]
            for place, name in enumerate(table["names"]):
                if name not in places:
                    found.append(Difference(f"{policy}, {method}, {name}: is not in the committed table"))
                    continue
                now, old = _row(columns, place), _row(then, places[name])
                if now != old:
                    ends_otherwise = columns["outcomes"][place] != then["outcomes"][places[name]]
                    found.append(Difference(f"{policy}, {method}, {name}: {now} instead of {old}", ends_otherwise))
    return found


def dump_json(value: Any, indent: int = 0) -> str:
    """JSON with lists of plain values on one line: diffs stay readable and the file small."""
    if isinstance(value, Mapping) and value:
        inner = " " * (indent + 2)
        lines = [f"{inner}{json.dumps(str(key))}: {dump_json(each, indent + 2)}" for key, each in value.items()]
        return "{\n" + ",\n".join(lines) + "\n" + " " * indent + "}"
    if isinstance(value, list | tuple) and any(isinstance(each, Mapping | list | tuple) for each in value):
        inner = " " * (indent + 2)
        return "[\n" + ",\n".join(inner + dump_json(each, indent + 2) for each in value) + "\n" + " " * indent + "]"
    return json.dumps(value, allow_nan=False)


def unequal(fresh: Any, kept: Any, path: str = "") -> list[str]:
    """Where the values of a tree are not those of another, in words; what only the other has is not looked at."""
    if isinstance(fresh, Mapping) and isinstance(kept, Mapping):
        return [
            line
            for name, value in fresh.items()
            for line in unequal(value, kept.get(name), f"{path}.{name}" if path else str(name))
        ]
    return [] if fresh == kept else [f"{path}: {fresh} instead of {kept}"]


def _row(columns: Mapping[str, Any], place: int) -> str:
    outcome, frames = columns["outcomes"][place], columns["frames"][place]
    return f"{outcome}, {frames} frames, {columns['doses'][place]:g} s, {columns['digests'][place]}"


def _corpus(measured: Measured) -> dict[str, Any]:
    benchmark = measured.benchmark
    return {
        "digest": benchmark.corpus_digest,
        "policy_model": benchmark.policy_digest or None,
        "violations": sum(case.is_violation for case in benchmark.cases),
        "successes": sum(not case.is_violation for case in benchmark.cases),
        "not_reproduced": list(measured.unreproduced),
    }


def _summaries(measured: Measured) -> dict[str, Any]:
    return _figures(measured.results)


def _family(measured: Measured, family: str) -> dict[str, Any]:
    chosen = {
        method: tuple(result for result in results if result.family == family)
        for method, results in measured.results.items()
    }
    return _figures(chosen)


def _figures(results: Mapping[str, tuple[CaseResult, ...]]) -> dict[str, Any]:
    bound = {result.case: result for result in results.get(HINDSIGHT, ())}
    ours = results.get(OURS)
    summaries = {}
    for method, mine in results.items():
        figures = summarise(mine)
        if bound:
            figures["bound"] = share_of_bound(mine, bound)
        if ours is not None and method != OURS:
            figures["adreft_minus_this"] = advantage(ours, mine)
        figures["trajectories"] = hashlib.sha256("".join(result.episode.digest for result in mine).encode()).hexdigest()
        summaries[method] = figures
    return summaries
