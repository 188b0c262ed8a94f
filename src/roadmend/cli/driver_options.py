"""Options of the commands that name who drives and who repairs."""

import click

from roadmend.cli.options import FILE
from roadmend.policies.registry import POLICIES
from roadmend.repair.registry import METHODS

POLICY = click.option("--policy", default="modular", show_default=True, type=click.Choice(sorted(POLICIES)))
POLICY_CORPUS = click.option(
    "--corpus", "corpus_file", type=FILE, help="The policy's corpus; config/corpora/POLICY.jsonl if not given."
)
REPAIR = click.option("--repair", "method", default="none", show_default=True, type=click.Choice(sorted(METHODS)))
REPAIR_SEED = click.option(
    "--seed",
    default=0,
    show_default=True,
    type=click.IntRange(0, 2**31 - 1),
    help="Seed of repair methods that draw numbers.",
)
