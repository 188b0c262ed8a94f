"""The benchmark of repair methods as one HTML page: nothing but the file itself is needed to read it."""

import base64
import html
import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from roadmend.evaluation import repair_charts, supporting_charts
from roadmend.evaluation.benchmark_tables import Table, all_tables, headline

Content = Mapping[str, Any]

_STYLE = """
:root { color-scheme: light; --ink: #1f2328; --muted: #626a72; --line: #d9dde1; --tint: #f5f7f9; --mark: #d55e00; }
* { box-sizing: border-box; }
body { margin: 0; background: #fff; color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 40px 24px 72px; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 8px; }
h2 { font-size: 1.25rem; margin: 48px 0 6px; }
p { max-width: 78ch; margin: 6px 0 14px; }
.note, footer, figcaption { color: var(--muted); font-size: .88rem; }
figure { margin: 18px 0 8px; }
figure img { width: 100%; height: auto; display: block; }
.scroll { overflow-x: auto; border: 1px solid var(--line); border-radius: 6px; }
table { border-collapse: collapse; width: 100%; font-size: .84rem; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 10px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
th { background: var(--tint); font-weight: 600; position: sticky; top: 0; }
tr:last-child td { border-bottom: 0; }
td.text, th.text { text-align: left; }
td.long { white-space: normal; min-width: 26ch; }
tr.ours td { font-weight: 600; background: #fdf3ec; }
nav { display: flex; flex-wrap: wrap; gap: 4px 18px; margin: 18px 0 8px; font-size: .9rem; }
a { color: #0a5a9c; }
code { background: var(--tint); padding: 1px 5px; border-radius: 4px; font-size: .88em; overflow-wrap: anywhere; }
footer { margin-top: 56px; border-top: 1px solid var(--line); padding-top: 14px; }
"""


def build_page(content: Content) -> str:
    """The page of a benchmark's content, with every chart that its figures allow."""
    charts: list[tuple[str, str, Callable[[], Figure | None]]] = [
        ("ΔE by method", "Dots with 95 % intervals; diamonds are the paper's figures, of another simulator.",
         lambda: repair_charts.delta_e_chart(content)),
        ("How violations end", "Only the goal counts as a fix: a car that merely stops has repaired nothing.",
         lambda: repair_charts.outcome_chart(content)),
        ("Intensity against ΔE", "Lower and further right is better.", lambda: repair_charts.scatter_chart(content)),
        ("Dose", "Seconds of full command a case; a mean over replaced frames cannot hide a long, weak interference.",
         lambda: repair_charts.dose_chart(content)),
        ("ΔE by family", "S1 left turn, S2 right turn, S3 crossing, S4 highway exit, S5 on-ramp merging.",
         lambda: repair_charts.family_chart(content)),
        ("Monitors", "Frames against the weak labels, driven without repair.",
         lambda: supporting_charts.monitor_chart(content)),
        ("Robustness", "Violations that testing techniques find, summed over the families: mean and range of the runs.",
         lambda: supporting_charts.robustness_chart(content["robustness"], content["titles"])),
        ("Cost", "From the scene and the policy's decision to the repaired command.",
         lambda: supporting_charts.cost_chart(content)),
    ]  # fmt: skip
    sections = [(_anchor("Main table"), "Main table", _table(headline(content)))]
    for title, caption, make in charts:
        figure = make()
        if figure is not None:
            sections.append((_anchor(title), title, _figure(figure, title, caption)))
    for table in all_tables(content):
        sections.append((_anchor(table.title), table.title, _note(table) + _table(table.rows)))  # noqa: PERF401
    links = "".join(f'<a href="#{anchor}">{html.escape(title)}</a>' for anchor, title, _ in sections)
    body = "".join(f'<section id="{a}"><h2>{html.escape(t)}</h2>{inner}</section>\n' for a, t, inner in sections)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Online repair of driving policies</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"<h1>Online repair of driving policies</h1>\n{_lead(content)}<nav>{links}</nav>\n{body}"
        f"<footer>{_origin(content)}</footer>\n</main>\n</body>\n</html>\n"
    )


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


def _figure(figure: Figure, title: str, caption: str) -> str:
    return (
        f'<figure><img alt="{html.escape(title)}" src="data:image/svg+xml;base64,{_svg(figure)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def _svg(figure: Figure) -> str:
    """The figure in base64; the same figure gives the same text."""
    buffer = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "roadmend", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return base64.b64encode(buffer.getvalue()).decode()


def _note(table: Table) -> str:
    return f'<p class="note">{html.escape(table.note)}</p>'


def _table(rows: Sequence[Sequence[str]]) -> str:
    head, *others = rows
    texts = [all(not _is_figure(row[column]) for row in others) for column in range(len(head))]
    lines = ["<tr>" + "".join(_cell("th", c, is_text=t) for c, t in zip(head, texts, strict=True)) + "</tr>"]
    for row in others:
        mark = ' class="ours"' if "ADReFT" in row[:2] and not row[0].startswith("paper") else ""
        lines.append(
            f"<tr{mark}>" + "".join(_cell("td", c, is_text=t) for c, t in zip(row, texts, strict=True)) + "</tr>"
        )
    return f'<div class="scroll"><table>{"".join(lines)}</table></div>'


def _cell(tag: str, text: str, *, is_text: bool) -> str:
    kinds = " ".join(["text"] * is_text + ["long"] * (tag == "td" and len(text) > 60))
    return f"<{tag}{f' class={chr(34)}{kinds}{chr(34)}' if kinds else ''}>{html.escape(text)}</{tag}>"


def _is_figure(text: str) -> bool:
    return text[:1].isdigit() or text[:1] in {"-", "\N{EN DASH}"}


def _anchor(title: str) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in title.lower())
