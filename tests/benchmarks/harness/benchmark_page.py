"""The benchmark of repair methods as one HTML page: nothing but the file itself is needed to read it."""

from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.figure import Figure

from harness import monitor_and_cost_charts, repair_charts
from harness.benchmark_tables import all_tables, headline
from harness.sections import Section, chart_section, render_sections, table_section

Content = Mapping[str, Any]


def build_page(content: Content) -> str:
    """The page of a benchmark's content, with every chart that its figures allow."""
    charts: list[tuple[str, str, Callable[[], Figure | None]]] = [
        (
            "ΔE by method",
            "Dots with 95 % intervals; diamonds are the paper's figures, of another simulator.",
            lambda: repair_charts.delta_e_chart(content),
        ),
        (
            "How violations end",
            "Only the goal counts as a fix: a car that merely stops has repaired nothing.",
            lambda: repair_charts.outcome_chart(content),
        ),
        ("Intensity against ΔE", "Lower and further right is better.", lambda: repair_charts.scatter_chart(content)),
        (
            "Dose",
            "Seconds of full command a case; a mean over replaced frames cannot hide a long, weak interference.",
            lambda: repair_charts.dose_chart(content),
        ),
        (
            "ΔE by family",
            "S1 left turn, S2 right turn, S3 crossing, S4 highway exit, S5 on-ramp merging.",
            lambda: repair_charts.family_chart(content),
        ),
        (
            "Monitors",
            "Frames against the weak labels, driven without repair.",
            lambda: monitor_and_cost_charts.monitor_chart(content),
        ),
        (
            "Robustness",
            "Violations that testing techniques find, summed over the families: mean and range of the runs.",
            lambda: monitor_and_cost_charts.robustness_chart(content["robustness"], content["titles"]),
        ),
        (
            "Cost",
            "From the scene and the policy's decision to the repaired command.",
            lambda: monitor_and_cost_charts.cost_chart(content),
        ),
    ]
    sections = [Section("Main table", rows=headline(content))]
    for title, caption, make in charts:
        figure = make()
        if figure is not None:
            sections.append(chart_section(title, caption, figure))
    sections += map(table_section, all_tables(content))
    policies = [_about(content, policy) for policy in content["policies"]]
    title = "Online repair of driving policies"
    return render_sections("repair.html", title, sections, policies=policies, made=content["provenance"])


def _about(content: Content, policy: str) -> dict[str, Any]:
    """What the page says of a policy at its head and its foot."""
    figures = content["summary"][policy].get("adreft")
    corpus = content["corpora"][policy]
    return {
        "name": policy,
        **{name: corpus[name] for name in ("violations", "successes", "digest")},
        "adreft": figures if figures is not None and figures["delta_e"] is not None else None,
    }
