"""The benchmark of repair methods as one HTML page: nothing but the file itself is needed to read it."""

import html
from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.figure import Figure

from harness import repair_charts, supporting_charts
from harness.benchmark_tables import all_tables, headline
from harness.page_parts import figure_part, note_part, table_part, whole_page

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
            lambda: supporting_charts.monitor_chart(content),
        ),
        (
            "Robustness",
            "Violations that testing techniques find, summed over the families: mean and range of the runs.",
            lambda: supporting_charts.robustness_chart(content["robustness"], content["titles"]),
        ),
        (
            "Cost",
            "From the scene and the policy's decision to the repaired command.",
            lambda: supporting_charts.cost_chart(content),
        ),
    ]
    sections = [("Main table", table_part(headline(content)))]
    for title, caption, make in charts:
        figure = make()
        if figure is not None:
            sections.append((title, figure_part(figure, title, caption)))
    sections += [(table.title, note_part(table) + table_part(table.rows)) for table in all_tables(content)]
    return whole_page("Online repair of driving policies", _lead(content), sections, _origin(content))


def _lead(content: Content) -> str:
    parts = []
    for policy in content["policies"]:
        corpus = content["corpora"][policy]
        figures = content["summary"][policy].get("adreft")
        said = f"{policy}: {corpus['violations']} violations, {corpus['successes']} successes"
        if figures is not None and figures["delta_e"] is not None:
            said += (
                f"; ADReFT fixes {figures['fix']:.1f} % and degrades {figures['deg']:.1f} %, "
                f"ΔE {figures['delta_e']:.1f}"
            )
        parts.append(html.escape(said))
    lead = (
        "Scenarios in which a driving policy collides (violations) or reaches its goal (successes), driven again with "
        "a repair method between the policy and the vehicle. A violation counts as fixed only if the ego completes its "
        "route in time."
    )
    return f"<p>{html.escape(lead)}</p><p>{'.<br>'.join(parts)}.</p>\n"


def _origin(content: Content) -> str:
    made = content["provenance"]
    machine = made["machine"]
    corpora = ", ".join(f"{policy} {content['corpora'][policy]['digest'][:12]}" for policy in content["policies"])
    changed = " (changed)" if made["dirty"] else ""
    return (
        f"Made by <code>{html.escape(made['command'])}</code> at commit {html.escape(made['commit'][:12])}{changed} on "
        f"{html.escape(str(machine['processor']))}, {machine['cores']} cores, Python {html.escape(machine['python'])}. "
        f"Corpora: {html.escape(corpora)}."
    )
