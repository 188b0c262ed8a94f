"""``./roadmend bench``: makes the figures of this repository, as ratios that are measured in one run."""

import sys
from collections.abc import Sequence

import click

from roadmend.cli.lazy import LazyGroup, Table
from roadmend.cli.main import run_group

_COMMANDS: Table = {
    "adreft": ("harness.bench_adreft", "adreft", "Every repair method on every policy, as the paper has it."),
    "controls": ("harness.bench_controls", "controls", "Whether it is the timing, and holds in other futures."),
    "exports": ("harness.bench_exports", "exports", "Exported crashes in other people's readers."),
    "liar": ("harness.bench_liar", "liar", "One false field in a language model's answers."),
    "loop": ("harness.bench_loop", "loop", "What the loop costs beside bare SUMO and a bare ring of nodes."),
    "ordinary": ("harness.bench_ordinary", "ordinary", "What repair costs where nothing was wrong."),
    "outcomes": ("harness.bench_outcomes", "outcomes", "How a policy fares in random scenarios."),
    "pages": ("harness.bench_pages", "pages", "Copy the committed figures into README and src/doc."),
    "recorder": ("harness.bench_recorder", "recorder", "What the recorder takes in, and what a kill costs."),
    "retrieval": ("harness.bench_retrieval", "retrieval", "Searching a bank of a million scenarios."),
    "safe": ("harness.bench_safe", "safe", "Crash reports into scenarios, beside the paper's figures."),
    "sera": ("harness.bench_sera", "sera", "What policies learn from recommended scenarios."),
    "texts": ("harness.bench_texts", "texts", "Crash texts in other registers, read and scored."),
}


@click.group(
    cls=LazyGroup,
    table=_COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
def bench() -> None:
    """Measure, in ratios."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a benchmark; the exit codes are those of ``roadmend``."""
    return run_group(bench, "roadmend bench", sys.argv[1:] if arguments is None else arguments)


if __name__ == "__main__":  # worker processes import this file under another name
    sys.exit(main())
