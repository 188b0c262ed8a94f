"""The benchmark of SERA as one tree of plain values, and its tables."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from statistics import fmean
from typing import Any

from harness.sera_experiment import ARMS, HALF_BANK
from harness.table import DASH, Table, number, span
from roadmend.measures.paired_test import mean_interval, paired_p_value
from roadmend.measures.summary import MEASURES

Content = Mapping[str, Any]
PAPER: dict[str, Any] = {  # SERA: Bench2Drive in CARLA; gains of Driving Score in percent, other policies
    "gain": {"UniAD": 4.34, "VAD": 4.18, "TCP": 3.93},
    "uniad": {"full": 35.10, "initial": 33.25},
    "success_rate": {"AD-MLP": 0.0},
}
_TITLES = {
    "driving_score": "Driving Score",
    "success_rate": "Success Rate",
    "efficiency": "Efficiency",
    "comfortness": "Comfortness",
}
_ARMS = {"base": "base", "random": "random", "initial": "initial", "full": "full", HALF_BANK: "full, half the bank"}


def build_content(results: Mapping[str, Content], retrieval: Content | None, made: Content, settings: Content) -> Any:
    """Everything that the benchmark says.

    Args:
        results: of the experiments, by policy.
        retrieval: of the committed figures of retrieval, if there are any.
        made: provenance.
        settings: sizes of the sets and how the policies were tuned.
    """
    return {
        "provenance": made,
        "settings": settings,
        "summary": {policy: _summary(found["seeds"]) for policy, found in results.items()},
        "intervals": {policy: _intervals(found["seeds"]) for policy, found in results.items()},
        "comparisons": {policy: _comparisons(found["seeds"]) for policy, found in results.items()},
        "forgetting": {policy: _forgetting(found["seeds"]) for policy, found in results.items()},
        "sweep": {policy: found["sweep"] for policy, found in results.items() if found["sweep"]},
        "seeds": {policy: found["seeds"] for policy, found in results.items()},
        "retrieval": None if retrieval is None else {name: retrieval[name] for name in ("n", "p95_ms", "recall_at_10")},
        "paper": PAPER,
    }


def _values(seeds: Sequence[Content], arm: str, measure: str) -> list[float]:
    return [one["arms"][arm][measure] for one in seeds if one["arms"][arm][measure] is not None]


def _arms(seeds: Sequence[Content]) -> list[str]:
    return [arm for arm in _ARMS if arm in seeds[0]["arms"]]


def _summary(seeds: Sequence[Content]) -> dict[str, dict[str, float | None]]:
    return {
        arm: {measure: fmean(values) if (values := _values(seeds, arm, measure)) else None for measure in MEASURES}
        for arm in _arms(seeds)
    }


def _intervals(seeds: Sequence[Content]) -> dict[str, dict[str, Any]]:
    return {arm: {name: mean_interval(_values(seeds, arm, name)) for name in MEASURES} for arm in _arms(seeds)}


def _comparisons(seeds: Sequence[Content]) -> dict[str, Any]:
    """Differences of the Driving Score, paired by seed: a minus b."""
    scores = {arm: _values(seeds, arm, "driving_score") for arm in _arms(seeds)}
    pairs = [
        ("full", "random"),
        ("full", "initial"),
        ("initial", "random"),
        ("random", "base"),
        ("full", "base"),
        ("full", HALF_BANK),
    ]
    found = {
        f"{a}_minus_{b}": {
            "difference": fmean(x - y for x, y in zip(scores[a], scores[b], strict=True)),
            "interval": mean_interval([x - y for x, y in zip(scores[a], scores[b], strict=True)]),
            "p_value": paired_p_value(scores[a], scores[b]),
        }
        for a, b in pairs
        if a in scores and b in scores
    }
    base = fmean(scores["base"])
    gain = 100.0 * (fmean(scores["full"]) / base - 1.0) if base else None
    order = [fmean(scores[arm]) for arm in ARMS]
    return {**found, "gain_percent": gain, "in_order": all(a < b for a, b in pairwise(order))}


def _forgetting(seeds: Sequence[Content]) -> dict[str, Any]:
    """Of the full selection: what became of ordinary scenarios, means over the seeds."""
    found = [one["forgetting"]["full"] for one in seeds]
    names = ("ordinary_change", "driving_score_change", "success_rate_change", "redrawn_before", "redrawn_change")
    means = {}
    for name in names:
        known = [one[name] for one in found if one[name] is not None]
        means[name] = fmean(known) if known else None
    return {
        **means,
        "ordinary": sum(one["ordinary"] for one in found),
        "went_well": sum(one["went_well"] for one in found),
    }


def main_rows(content: Content) -> tuple[tuple[str, ...], ...]:
    """The table of the paper: a policy and an arm a row."""
    rows = [("policy", "scenarios learnt from", *(title for name in MEASURES for title in (_TITLES[name], "95 %")))]
    for policy, arms in content["summary"].items():
        for arm, values in arms.items():
            intervals = content["intervals"][policy][arm]
            cells = [cell for name in MEASURES for cell in (number(values[name]), span(intervals[name]))]
            rows.append((policy, _ARMS[arm], *cells))
    return tuple(rows)


def tables(content: Content) -> list[Table]:
    """The other tables."""
    return [_comparison_table(content), _forgetting_table(content), _sweep_table(content), _retrieval_table(content)]


def _comparison_table(content: Content) -> Table:
    rows = [
        (
            "policy",
            "full over base",
            "random - base",
            "initial - random",
            "full - initial",
            "full - random",
            "p, full against random",
            "full - half the bank",
        )
    ]
    for policy, found in content["comparisons"].items():
        rows.append(
            (
                policy,
                DASH if found["gain_percent"] is None else f"{found['gain_percent']:+.1f} %",
                *(
                    f"{found[name]['difference']:+.2f}"
                    for name in ("random_minus_base", "initial_minus_random", "full_minus_initial", "full_minus_random")
                ),
                number(found["full_minus_random"]["p_value"], 3),
                _signed(found.get("full_minus_half_bank", {}).get("difference")),
            )
        )
    note = "Driving Score, paired by seed; p of the two-sided paired t-test over the seeds."
    return Table("Comparisons", note, tuple(rows))


def _forgetting_table(content: Content) -> Table:
    rows = [
        (
            "policy",
            "ordinary scenarios",
            "change",
            "that went well before",
            "change",
            "Success Rate",
            "base, drawn anew",
            "change, drawn anew",
        )
    ]
    for policy, found in content["forgetting"].items():
        rows.append(
            (
                policy,
                str(found["ordinary"]),
                _signed(found["ordinary_change"]),
                str(found["went_well"]),
                _signed(found["driving_score_change"]),
                _signed(found["success_rate_change"]),
                number(found["redrawn_before"]),
                _signed(found["redrawn_change"]),
            )
        )
    note = (
        "Driving Score of the full selection less that of the base on ordinary scenarios, in points, over all seeds: those "
        "of the evaluation set that are no violations, drawn at random or found by searches to go well under another policy. "
        "Those that went well before can only lose, so both drive them again, twice, with other random numbers for SUMO's "
        "drivers (drawn anew: the Driving Score of the base there, and the change); these alter how much the others dawdle, "
        "and nothing else."
    )
    return Table("Forgetting", note, tuple(rows))


def _sweep_table(content: Content) -> Table:
    rows = [("policy", "epochs", "learning rate", *(_TITLES[name] for name in MEASURES))]
    rows += [
        (policy, str(row["epochs"]), f"{row['learning_rate']:g}", *(number(row[name]) for name in MEASURES))
        for policy, found in content["sweep"].items()
        for row in found
    ]
    return Table(
        "Epochs and learning rate", "Full selection of the first seed; the last epoch, unguarded.", tuple(rows)
    )


def _retrieval_table(content: Content) -> Table:
    found = content["retrieval"]
    rows = [("scenarios", "p95", "recall@10")]
    if found is not None:
        rows.append((f"{found['n']:,}", f"{found['p95_ms']:.2f} ms", f"{found['recall_at_10']:.4f}"))
    return Table("Retrieval", "From the committed figures of 'roadmend bench retrieval'.", tuple(rows))


def _signed(value: float | None) -> str:
    return DASH if value is None else f"{value:+.2f}"
