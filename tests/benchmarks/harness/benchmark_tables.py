"""The benchmark of repair methods as tables: the paper's 1 to 5, ours beside them, and what it adds."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from harness.table import DASH, Table, number, span

Content = Mapping[str, Any]


def headline(content: Content) -> tuple[tuple[str, ...], ...]:
    """The main table's rows: a method a row, both policies side by side."""
    policies = content["policies"]
    head = ["method"]
    for policy in policies:
        head += [f"{policy}: %Fix", "%Deg", "ΔE", "intensity", "dose [s]"]
    rows = [tuple(head)]
    for method in methods_of(content):
        cells = [title_of(content, method)]
        for policy in policies:
            figures = content["summary"][policy].get(method)
            if figures is None:
                cells += [DASH] * 5
                continue
            interval = span(figures["intervals"]["delta_e"])
            cells += [
                number(figures["fix"]),
                number(figures["deg"]),
                f"{number(figures['delta_e'])} ({interval})",
                number(figures["intensity"], 2),
                number(figures["dose"], 2),
            ]
        rows.append(tuple(cells))
    return tuple(rows)


def all_tables(content: Content) -> list[Table]:
    """Every table of the report, empty ones left out."""
    makers: list[Callable[[Content], Table | None]] = [
        _outcomes,
        _effectiveness,
        _intensity,
        _monitor,
        _strategies,
        robustness_table,
        _cost,
        _bound,
        _advantage,
        _rivals,
        _not_run,
    ]
    return [table for maker in makers if (table := maker(content)) is not None]


def methods_of(content: Content) -> list[str]:
    """Methods that ran under any policy, in the order of the plan."""
    return [name for name in content["titles"] if any(name in content["summary"][p] for p in content["policies"])]


def title_of(content: Content, method: str) -> str:
    """What a method is called in tables."""
    return str(content["titles"].get(method, {}).get("title", _OTHERS.get(method, method)))


def monitor_title(content: Content, method: str) -> str:
    """What a method is called as a monitor; the paper has names of its own."""
    named = {"rule": "RuleBase", "model": "SelfOracle"}.get(method) or content.get("monitor_titles", {}).get(method)
    return str(named or title_of(content, method))


def _each(content: Content) -> list[tuple[str, str, Mapping[str, Any]]]:
    """Policy, method and figures, in the order of the tables."""
    return [
        (policy, method, content["summary"][policy][method])
        for policy in content["policies"]
        for method in methods_of(content)
        if method in content["summary"][policy]
    ]


def _outcomes(content: Content) -> Table:
    rows = [
        (
            "policy",
            "method",
            "%Fix",
            "%Deg",
            "ΔE",
            "95 %",
            "%Fix loose",
            "stopped",
            "goal lost",
            "intensity",
            "95 %",
            "dose [s]",
            "95 %",
            "frames",
            "deceleration",
            "jerk",
        )
    ]
    for policy, method, figures in _each(content):
        intervals = figures["intervals"]
        rows.append(
            (
                policy,
                title_of(content, method),
                number(figures["fix"]),
                number(figures["deg"]),
                number(figures["delta_e"]),
                span(intervals["delta_e"]),
                number(figures["fix_loose"]),
                number(figures["stopped"]),
                number(figures["goal_lost"]),
                number(figures["intensity"], 2),
                span(intervals["intensity"], 2),
                number(figures["dose"], 2),
                span(intervals["dose"], 2),
                number(figures["intervened_frames"]),
                number(figures["peak_deceleration"], 2),
                number(figures["peak_jerk"], 1),
            )
        )
    note = (
        "%Fix: violations that end at the goal; loose: that no longer end in a collision, as the paper counts. %Deg: "
        "successes that end in a collision. ΔE = %Fix - %Deg. Stopped: violations that now run into the time limit "
        "(no fix). Goal lost: successes that no longer reach the goal, for any reason. Intensity: mean of |policy's "
        "action - final action| over all replaced frames of all cases pooled, 0 .. 2. Dose: the same summed over an "
        "episode, times the tick, mean over all cases. Frames: replaced ones a case. Deceleration [m/s²] and jerk "
        "[m/s³]: means over cases of the peak of the ego's, from its speed at 20 Hz, means over 0.2 s. Intervals are "
        "95 %: for ΔE the wider one, on each side, of Newcombe's and of the bootstrap over searches, since cases that one "
        "search found are alike; for shares likewise of Wilson's and of that bootstrap; that bootstrap for the others."
    )
    return Table("All figures", note, tuple(rows))


def _effectiveness(content: Content) -> Table:
    families = list(content["families"])
    head = ["policy", "method"]
    for family in [*families, "all"]:
        head += [f"{family} %Fix", "%Deg", "ΔE"]
    rows = [tuple(head)]
    for policy, method, figures in _each(content):
        cells = [policy, title_of(content, method)]
        for part in [*(content["families"][family][policy][method] for family in families), figures]:
            cells += [number(part["fix"]), number(part["deg"]), number(part["delta_e"])]
        rows.append(tuple(cells))
    rows += _paper_rows(content, families, ("fix", "deg", "delta_e"), 1)
    return Table("Effectiveness by family (the paper's table 1)", _PAPER_NOTE, tuple(rows))


def _intensity(content: Content) -> Table:
    families = list(content["families"])
    rows = [("policy", "method", *families, "mean of families", "all frames")]
    for policy, method, figures in _each(content):
        values = [content["families"][family][policy][method]["intensity"] for family in families]
        known = [value for value in values if value is not None]
        mean = sum(known) / len(known) if known else None
        cells = [number(value, 2) for value in [*values, mean, figures["intensity"]]]
        rows.append((policy, title_of(content, method), *cells))
    rows += [(*row, DASH) for row in _paper_rows(content, families, ("intensity",), 2)]
    note = "The paper's average is the mean of the families; ours in the last column pools all replaced frames. "
    return Table("Intensity by family (the paper's table 2)", note + _PAPER_NOTE, tuple(rows))


def _paper_rows(content: Content, families: Sequence[str], names: Sequence[str], digits: int) -> list[tuple[str, ...]]:
    paper = content["paper"]
    rows = []
    for policy in content["policies"]:
        for method, total in paper["summary"].get(policy, {}).items():
            parts = [paper["families"][family][policy].get(method) for family in families]
            if None in parts:
                continue
            cells = [number(part[name], digits) for part in [*parts, total] for name in names]
            rows.append((f"paper, {paper['policies'][policy]}", title_of(content, method), *cells))
    return rows


def _monitor(content: Content) -> Table | None:
    rows: list[tuple[str, ...]] = [
        ("policy", "monitor", "precision", "recall", "F1", "95 % of F1", "paper's P / R / F1")
    ]
    for policy in content["policies"]:
        for name, figures in content["monitor"].get(policy, {}).items():
            theirs = content["paper"]["monitor"].get(policy, {}).get(name)
            beside = " / ".join(number(theirs[key], 2) for key in ("precision", "recall", "f1")) if theirs else DASH
            rows.append(
                (
                    policy,
                    monitor_title(content, name),
                    number(figures["precision"], 2),
                    number(figures["recall"], 2),
                    number(figures["f1"], 2),
                    span(figures["intervals"]["f1"]),
                    beside,
                )
            )
    note = (
        "Frames of the test cases, driven without repair, against the weak labels (nearer than 1 m to somebody, or "
        "less than 3 s before a collision); an alarm is a score above the method's threshold. The bootstrap draws "
        "episodes."
    )
    return Table("Monitors (the paper's table 3)", note, tuple(rows)) if len(rows) > 1 else None


def _strategies(content: Content) -> Table | None:
    rows = [("policy", "method", "%Fix", "%Deg", "ΔE", "intensity", "paper's %Fix / %Deg / ΔE / intensity")]
    groups = {name for name, about in content["titles"].items() if about["group"] in {"adreft", "variant", "ablation"}}
    for policy, method, figures in _each(content):
        if method not in groups:
            continue
        theirs = content["paper"]["summary"].get(policy, {}).get(method)
        beside = DASH
        if theirs:
            beside = " / ".join([*(number(theirs[n]) for n in ("fix", "deg", "delta_e")), f"{theirs['intensity']:.2f}"])
        rows.append(
            (
                policy,
                title_of(content, method),
                number(figures["fix"]),
                number(figures["deg"]),
                number(figures["delta_e"]),
                number(figures["intensity"], 2),
                beside,
            )
        )
    return Table("Ablations (the paper's table 4)", _PAPER_NOTE, tuple(rows)) if len(rows) > 1 else None


def _cost(content: Content) -> Table | None:
    cost = content["cost"]
    if not cost:
        return None
    rows = [("method", "median [ms]", "p99 [ms]", "PyTorch eager / this", "model [kB]", "paper's mean [ms]")]
    for method, figures in cost.items():
        theirs = content["paper"]["cost"].get(method, {}).get("mean_ms")
        ratio = figures.get("ratio")
        size = _model_size(content, method)
        rows.append(
            (
                title_of(content, method),
                number(figures["median_ms"], 3),
                number(figures["p99_ms"], 3),
                number(ratio and 1.0 / ratio, 1),
                number(size / 1000 if size else None, 0),
                number(theirs, 3),
            )
        )
    note = "One frame with 20 objects on one core, from the scene and the policy's decision to the repaired command."
    return Table("Cost (the paper's table 5)", note, tuple(rows))


def robustness_table(content: Content) -> Table | None:
    """How many violations the searches found, where they were run."""
    robustness = content["robustness"]
    rows = [("policy", "technique", "method", "scenarios", "violations found, mean", "least .. most")]
    for policy, techniques in (robustness or {"policies": {}})["policies"].items():
        for technique, curves in techniques.items():
            for method, curve in curves.items():
                found = [run[-1] for run in curve["found"]]
                rows.append(
                    (
                        policy,
                        technique,
                        title_of(content, method),
                        str(curve["evaluations"][-1]),
                        number(sum(found) / len(found)),
                        span([min(found), max(found)], 0),
                    )
                )
    note = "Searches of every technique in every family, several runs each, against the policy with and without repair."
    return Table("Robustness (the paper's figure 3)", note, tuple(rows)) if len(rows) > 1 else None


def _model_size(content: Content, method: str) -> int | None:
    for contenders in content["contenders"].values():
        model = contenders.get(method, {}).get("model")
        if model:
            return int(model["bytes"])
    return None


def _bound(content: Content) -> Table | None:
    rows = [("policy", "method", "repairable", "of those fixed", "dose / bound", "dose / bound, fixed or not")]
    for policy, method, figures in _each(content):
        bound = figures.get("bound")
        if bound is not None:
            rows.append(
                (
                    policy,
                    title_of(content, method),
                    f"{bound['repairable']} of {figures['violations']}",
                    f"{number(bound['fix_share'])} %",
                    number(bound["dose_ratio"], 2),
                    number(bound["dose_ratio_all"], 2),
                )
            )
    note = (
        "The bound is the least dose found over re-simulations of a violation, by a search that knows how it ends. "
        "Repairable: violations for which it found any that reaches the goal. Dose / bound: sums over the violations "
        "that both repair; last column: over all repairable ones."
    )
    return Table("Against hindsight", note, tuple(rows)) if len(rows) > 1 else None


def _advantage(content: Content) -> Table | None:
    rows = [("policy", "against", "ΔE, ADReFT - this", "95 %", "dose [s], ADReFT - this", "95 %")]
    for policy, method, figures in _each(content):
        more = figures.get("adreft_minus_this")
        if more is not None:
            intervals = more["intervals"]
            rows.append(
                (
                    policy,
                    title_of(content, method),
                    number(more["delta_e"]),
                    span(intervals["delta_e"]),
                    number(more["dose"], 2),
                    span(intervals["dose"], 2),
                )
            )
    note = "On the same cases; intervals of the paired bootstrap over searches. One that holds 0 shows no difference."
    return Table("ADReFT against each", note, tuple(rows)) if len(rows) > 1 else None


def _rivals(content: Content) -> Table:
    rows = [("policy", "method", "repair method", "tuned", "parameters that differ from its defaults", "model")]
    for policy in content["policies"]:
        for name, about in content["contenders"][policy].items():
            chosen = ", ".join(f"{key} {value}" for key, value in about["parameters"].items()) or DASH
            model = about.get("model")
            known = f"{model['file']} {model['digest'][:12]}" if model else DASH
            rows.append(
                (policy, title_of(content, name), about["method"], "yes" if about["tuned"] else DASH, chosen, known)
            )
    note = "Tuned: with the parameters that were found best for it on the validation set."
    return Table("Who took part", note, tuple(rows))


def _not_run(content: Content) -> Table | None:
    rows = [("policy", "method", "why")]
    rows += [(absence["policy"], absence["method"], absence["reason"]) for absence in content["not_run"]]
    return Table("Not run", "Methods of the plan that are missing above.", tuple(rows)) if len(rows) > 1 else None


_OTHERS = {"torch_eager": "ADReFT in plain PyTorch"}
_PAPER_NOTE = (
    "The paper's rows are of another simulator and other policies (Pylot is modular, Roach neural) and count a case as "
    "fixed that no longer collides, goal reached or not."
)
