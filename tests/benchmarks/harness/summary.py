"""The figures of the README: one table from the committed results of several benchmarks."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from harness.benchmark_files import read_json
from harness.kept_rows import paired_cases
from roadmend.measures.intervals import wilson
from roadmend.measures.repair import advantage_of

_MORE = "[ADReFT](src/doc/adreft.md)"
_RIVALS = ("random", "rule", "model", "rss", "predictive", "predictive_adaptive", "gated")


def summary(benchmarks: Path) -> list[list[str]]:
    """What was measured, on what, its 95 % interval, and the page that has the command; the first row is the heading.

    Args:
        benchmarks: the folder of the committed results.

    Raises:
        InputError: a result is missing or damaged.
    """
    rows = [["what", "measured on", "figure", "95 %", "more"]]
    rows += _repair(read_json(benchmarks / "adreft.json"), read_json(benchmarks / "adreft-cases.json"))
    for path in sorted(benchmarks.glob("adreft-fresh-*.json")):
        if not path.stem.endswith("-cases"):
            rows += _fresh(read_json(path))
    rows += _ordinary(read_json(benchmarks / "adreft-ordinary.json"))
    rows += _scenario_repair(read_json(benchmarks / "sera.json"))
    rows += _reports(read_json(benchmarks / "safe.json"))
    return rows


def _repair(content: Mapping[str, Any], cases: Mapping[str, Any]) -> Iterator[list[str]]:
    for policy, methods in content["summary"].items():
        own = methods["adreft"]
        where = f"{policy} policy, {own['violations']} persistent violations, {own['successes']} successes"
        shown = [("adreft", "ΔE of"), ("always_needed", "ΔE of")]
        shown.append((max(_RIVALS, key=lambda rival: methods[rival]["delta_e"]), "best rival,"))
        for name, title in shown:
            yield _own(f"{title} {content['titles'][name]['title']}", where, methods[name])
            where = "the same"
        lead = methods["gated"]["adreft_minus_this"]
        figure = f"{lead['delta_e']:+.1f}"
        yield ["over rules with its own prediction", where, figure, _span(lead["intervals"]["delta_e"]), _MORE]
        stages = [cases[policy]["methods"].get(name) for name in ("rollouts", "first_stage")]
        if all(stages):
            lead = advantage_of(*(paired_cases(cases[policy], name) for name in ("rollouts", "first_stage")))
            figure = f"{lead['delta_e']:+.1f}"
            yield [
                "fine-tuning by rollouts over its first stage",
                where,
                figure,
                _span(lead["intervals"]["delta_e"]),
                _MORE,
            ]


def _fresh(content: Mapping[str, Any]) -> Iterator[list[str]]:
    """The test cases were looked at at every step of the way, those of a fresh seed never."""
    for policy, methods in content["summary"].items():
        own = methods.get("adreft")
        if own is None:  # a fresh set may be of rivals alone
            continue
        where = f"{policy} policy, {own['violations']} violations, {own['successes']} successes of a fresh seed"
        yield _own(f"ΔE of {content['titles']['adreft']['title']}", where, own)


def _own(what: str, where: str, found: Mapping[str, Any]) -> list[str]:
    """The row of a method's ΔE."""
    figure = f"{found['delta_e']:.1f} at a dose of {found['dose']:.1f} s"
    return [what, where, figure, _span(found["intervals"]["delta_e"]), _MORE]


def _ordinary(content: Mapping[str, Any]) -> Iterator[list[str]]:
    """Random drives alone: those on networks are too few for one screen of results, and on the page."""
    for policy, methods in content["ordinary"]["random"].items():
        own = methods["adreft"]
        count = own["drives"]
        share = [100 * side for side in wilson(round(own["untouched"] * count / 100), count)]
        place = f"{policy} policy, {count} ordinary drives (random)"
        yield ["drives left untouched [%]", place, f"{own['untouched']:.1f}", _span(share), _MORE]
        if own["time_lost"] is not None:
            middle = f"median {own['time_lost_median']:.2f}"
            yield ["time lost [%]", "the same", f"{own['time_lost']:.2f}", middle, _MORE]
        figure = f"{own['collisions']}, {own['new_collisions']} of them new"
        what = f"collisions by its own fault, {own['collisions_bare']} without repair"
        yield [what, f"{policy} policy, all {count + own['collisions_bare']:,} random drives", figure, "", _MORE]


def _scenario_repair(content: Mapping[str, Any]) -> Iterator[list[str]]:
    more = "[SERA](src/doc/sera.md)"
    for policy, compared in content["comparisons"].items():
        where = f"{policy}, {content['settings']['seeds']} seeds"
        for key, title in (
            ("full_minus_base", "Driving Score gained by 24 scenarios"),
            ("full_minus_random", "of which over random ones"),
        ):
            gain = compared[key]
            yield [title, where, f"{gain['difference']:+.1f}", _span(gain["interval"]), more]


def _reports(content: Mapping[str, Any]) -> Iterator[list[str]]:
    more = "[SAFE](src/doc/safe.md)"
    reports = content["reports"]
    if "reproduction" in content:  # by the judge
        counts = {policy: found["reproduced"] for policy, found in content["reproduction"]["policies"].items()}
    else:
        counts = content["reproduced"]
    for policy, reproduced in counts.items():
        share = [100 * side for side in wilson(reproduced, reports)]
        where = f"{reports} crash reports, {policy} policy"
        yield ["crashes reproduced [%]", where, f"{100 * reproduced / reports:.1f}", _span(share), more]
    for group, what in (("unseen", "reports, text only"), ("other_registers", "texts in other registers")):
        found = content["extraction"].get(group)
        if found is not None:
            cases = found["cases"]
            share = [100 * side for side in wilson(round(found["overall"] * cases / 100), cases)]
            where = f"{cases} {what}, none of which the reader was written on"
            yield ["reports read right in every field [%]", where, f"{found['overall']:.1f}", _span(share), more]


def _span(interval: Sequence[float]) -> str:
    return f"{interval[0]:.1f} .. {interval[1]:.1f}"
