"""The benchmark of SERA on disk: JSON, Markdown, and a page with charts."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from harness.chart_labels import GROUP_COLOUR, add_legend
from harness.sections import Section, chart_section, render_sections, table_section
from harness.sera_experiment import ARMS
from harness.sera_summary import main_rows, tables
from roadmend.core.markdown import table_text
from roadmend.core.whole_file import write_texts
from roadmend.reports.chart_style import INK, despine, new_figure
from roadmend.reports.result_files import origin
from roadmend.world.families import FAMILIES

Content = Mapping[str, Any]
TITLE = "Few-shot repair of driving policies"
_COLOURS = dict(zip(ARMS, (GROUP_COLOUR[name] for name in ("reference", "rival", "variant", "adreft")), strict=True))


def write_sera(folder: Path, stem: str, content: Content) -> None:
    """Write STEM.json, STEM.md (what the README shows), STEM-tables.md (the other tables) and STEM.html.

    Raises:
        InputError: the folder cannot be written.
    """
    rows = main_rows(content)
    comparisons, forgetting, *_ = tables(content)
    shown = "\n\n".join(table.markdown().partition("\n\n")[2] for table in (comparisons, forgetting))
    others = "\n\n".join(table.markdown() for table in tables(content))
    made = origin(content["provenance"])
    write_texts(
        folder,
        {
            f"{stem}.json": json.dumps(content, indent=2, allow_nan=False) + "\n",
            f"{stem}.md": f"# {TITLE}\n\n{table_text(rows)}\n\n{lead(content)}\n\n{shown}\n\n{made}\n",
            f"{stem}-tables.md": f"# {TITLE}: the other tables\n\n{others}\n\n{made}\n",
            f"{stem}.html": build_page(content),
        },
    )


def lead(content: Content) -> str:
    """What was measured, in words."""
    sizes = content["settings"]
    seed = sizes.get("fresh_seed")
    source = f"of a corpus's {sizes['split']} split" if seed is None else f"from searches with seed {seed}"
    return (
        f"Each of {sizes['seeds']} seeds halves an evaluation set of {sizes['evaluation']} scenarios ({sizes['hard']} "
        f"of them violations {source}; {_others(sizes)}). What fails in one half is "
        f"analysed, and scenarios are taken from a bank of {sizes['bank']} that holds none of the set: at random, by "
        "the first recommendation, by the one after reflection. The policy learns from them and is measured on the "
        "other half, beside itself as it was. Means over the seeds with 95 % intervals by Student's t."
    )


def _others(sizes: Content) -> str:
    """What an evaluation set holds besides violations, in words."""
    families = len(FAMILIES)
    found, drawn = (families * sizes["plan"]["evaluation"][name] for name in ("successes", "ordinary"))
    return f"{found} that went well in the same searches for another policy, and {drawn} drawn at random"


def build_page(content: Content) -> str:
    """The page."""
    sections = [
        Section("Main table", rows=main_rows(content)),
        chart_section(
            "Driving Score by seed",
            "Lines join the arms of one seed; the bars are means.",
            score_chart(content),
        ),
    ]
    if content["sweep"]:
        caption = "Driving Score; the line is the base of the first seed."
        sections.append(chart_section("Epochs and learning rate, drawn", caption, sweep_chart(content)))
    sections += map(table_section, tables(content))
    return render_sections("sera.html", TITLE, sections, lead=lead(content), made=origin(content["provenance"]))


def score_chart(content: Content) -> Figure:
    """Driving Score of every arm and seed."""
    policies = list(content["summary"])
    figure, panels = new_figure(policies, 3.8, share_y=True, legend=False)
    for axes, policy in zip(panels, policies, strict=True):
        means = [content["summary"][policy][arm]["driving_score"] for arm in ARMS]
        axes.bar(range(len(ARMS)), means, color=[_COLOURS[arm] for arm in ARMS], alpha=0.35, width=0.7)
        for one in content["seeds"][policy]:
            scores = [one["arms"][arm]["driving_score"] for arm in ARMS]
            axes.plot(range(len(ARMS)), scores, "o-", color=INK, ms=4, lw=0.7)
        axes.set_xticks(range(len(ARMS)), ARMS)
        despine(axes, "y")
    panels[0].set_ylabel("Driving Score")
    return figure


def sweep_chart(content: Content) -> Figure:
    """Driving Score over the learning rate, a line for each number of epochs."""
    policies = list(content["sweep"])
    figure, panels = new_figure(policies, 3.4, share_y=True)
    colours = [*GROUP_COLOUR.values()]
    handles: dict[int, Any] = {}
    for axes, policy in zip(panels, policies, strict=True):
        rows = content["sweep"][policy]
        for place, epochs in enumerate(sorted({row["epochs"] for row in rows})):
            points = [(row["learning_rate"], row["driving_score"]) for row in rows if row["epochs"] == epochs]
            label = f"{epochs} epoch{'s' if epochs > 1 else ''}"
            (handles[epochs],) = axes.plot(
                *zip(*points, strict=True), "o-", color=colours[place % 6], ms=4, label=label
            )
        base = content["seeds"][policy][0]["arms"]["base"]["driving_score"]
        axes.axhline(base, color=INK, lw=0.8, ls="--")
        axes.set_xscale("log")
        axes.set_xlabel("learning rate")
        despine(axes, "y")
    panels[0].set_ylabel("Driving Score")
    add_legend(figure, list(handles.values()))
    return figure
