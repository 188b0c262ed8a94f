"""Options of the commands that name who drives and who repairs."""

import click

from roadmend.cli.options import FILE, NameType
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY

POLICY_NAME = NameType(POLICY_REGISTRY)
METHOD_NAME = NameType(METHOD_REGISTRY)
POLICY = click.option("--policy", default="modular", show_default=True, type=POLICY_NAME)
POLICIES = click.option(
    "--policy",
    "policies",
    multiple=True,
    default=["modular"],
    show_default=True,
    type=POLICY_NAME,
    help="May be repeated.",
)
RUN_POLICY = click.option(
    "--policy",
    default="modular",
    show_default=True,
    type=NameType(POLICY_REGISTRY, also=("external",)),
    help="external: a node of your own publishes the commands; it is waited for.",
)
TUNED = click.option(
    "--tuned/--no-tuned",
    default=True,
    show_default=True,
    help="Take the model and the settings of the repair method that were made for the policy; else its defaults.",
)
POLICY_CORPUS = click.option(
    "--corpus", "corpus_file", type=FILE, help="The policy's corpus; config/corpora/POLICY.jsonl if not given."
)
DROVE = click.option(
    "--policy", default="", type=POLICY_NAME, help="Who drove, if it is code of yours.  [default: as the bag says]"
)
REPAIR = click.option("--repair", "method", default="none", show_default=True, type=METHOD_NAME)
REPAIR_SEED = click.option(
    "--seed",
    default=0,
    show_default=True,
    type=click.IntRange(0, 2**31 - 1),
    help="Seed of repair methods that draw numbers.",
)
