"""``roadmend bag need``: which interventions of a recorded run were rescues, and which a nuisance."""

import json
from pathlib import Path

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import DROVE
from roadmend.cli.options import FUTURES_MAX, JSON, PATH
from roadmend.cli.output import Waiting, bag_progress, wide_console
from roadmend.cli.spell_table import account_figures, show_spells
from roadmend.core.spell import Spell
from roadmend.core.spell_account import with_needs
from roadmend.measures.need import HORIZON, run_with_need
from roadmend.measures.need_verdict import NEEDLESS, RESCUE, NeedVerdict, verdict_of
from roadmend.policies.registry import make_policy
from roadmend.recording.info import bag_info
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import read_plan, recorded_result
from roadmend.recording.recovery import bag_size
from roadmend.recording.resimulation import Switchover
from roadmend.recording.ticks import BagTicks
from roadmend.repair.registry import make_repairer


@click.command(
    cls=ExampleCommand,
    examples=["roadmend bag need bags/my-run", "roadmend bag need bags/my-run --futures 100 --json"],
    epilog=f"need: share of futures of the intervention's first tick, the policy left alone, that end within {HORIZON:g} s "
    f"in a collision by the ego's fault. From {RESCUE:g} on it is a rescue, below {NEEDLESS:g} a nuisance. worth: what the "
    "method itself judged, in prices of a collision.",
)
@click.argument("bag", type=PATH)
@click.option(
    "--futures", default=20, show_default=True, type=click.IntRange(1, FUTURES_MAX), help="Of each intervention."
)
@DROVE
@JSON
def need(bag: Path, futures: int, policy: str, *, as_json: bool) -> None:
    """Drive a recorded run again and tell of every intervention what would have come without it.

    The run must repeat itself bit for bit; futures differ in what the others want and in how exactly the ego obeys.
    """
    with bag_progress("reading", bag_size(bag)) as advance:
        told = bag_info(bag, advance).spells
    spells = with_needs(told, needs_of(bag, futures, policy))
    if as_json:
        figures = [account_figures(account) for account in spells]
        click.echo(json.dumps({"bag": str(bag), "futures": futures, "spells": figures}, indent=2))
        return
    if spells:
        show_spells(spells, wide_console())
    nuisances = sum(verdict_of(account.spell.need) is NeedVerdict.NUISANCE for account in spells)
    click.echo(f"{len(spells)} interventions, {nuisances} of them a nuisance")


def needs_of(bag: Path, futures: int, policy: str = "") -> tuple[Spell, ...]:
    """Every spell of a bag's run with its need, from ``futures`` futures each.

    Raises:
        InputError: the bag is unusable, or the world differs from the recorded one.
        SimulationError: SUMO failed.
    """
    reader = BagReader(bag)
    plan, ticks = read_plan(reader, policy), BagTicks(reader)
    then = recorded_result(ticks, plan)
    played = Switchover(ticks, make_repairer("none"), then.duration + 1.0)
    with Waiting(f"{plan.scenario.name}: {futures} futures of {len(then.spells)} interventions"):
        return run_with_need(plan.scenario, make_policy(plan.policy, plan.policy_parameters), played, futures).spells
