"""``roadmend bag need``: which interventions of a recorded run were rescues, and which a nuisance."""

import json
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.table import Table

from roadmend.cli.options import JSON, PATH
from roadmend.cli.output import wide_console
from roadmend.core.repair import Repair
from roadmend.measures.need import HORIZON, NEEDLESS, run_with_need
from roadmend.policies.registry import make_policy
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import read_plan, recorded_result
from roadmend.recording.resimulation import Switchover
from roadmend.recording.ticks import BagTicks
from roadmend.repair.registry import make_repairer

_RESCUE = 0.5  # need from which a spell is called so
_STYLES = {"rescue": "green", "in doubt": "yellow", "needless": "red"}


@click.command(
    epilog=f"need: share of futures of the intervention's first tick, the policy left alone, that end within {HORIZON:g} s "
    f"in a collision by the ego's fault. From {_RESCUE:g} on it is a rescue, below {NEEDLESS:g} needless."
)
@click.argument("bag", type=PATH)
@click.option("--futures", default=20, show_default=True, type=click.IntRange(1, 1000), help="Of each intervention.")
@JSON
def need(bag: Path, futures: int, *, as_json: bool) -> None:
    """Drive a recorded run again and tell of every intervention what would have come without it.

    The run must repeat itself bit for bit; futures differ in what the others want and in how exactly the ego obeys.
    """
    spells = needs_of(bag, futures)
    if as_json:
        click.echo(json.dumps({"bag": str(bag), "futures": futures, "spells": spells}, indent=2))
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("begins", "lasts", "dose", "need"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("")
    table.add_column("because of")
    table.add_column("why")
    for spell in spells:
        verdict = spell["verdict"]
        table.add_row(
            f"{spell['begin']:.2f} s",
            f"{spell['duration']:.2f} s",
            f"{spell['dose']:.2f} s",
            f"{spell['need']:.2f}",
            f"[{_STYLES[verdict]}]{verdict}[/]",
            ", ".join(map(str, spell["objects"])) or "-",
            spell["reason"],
        )
    wide_console().print(table)
    needless = sum(spell["verdict"] == "needless" for spell in spells)
    click.echo(f"{len(spells)} interventions, {needless} of them needless")


def needs_of(bag: Path, futures: int) -> list[dict[str, Any]]:
    """Every spell of a bag's run with its need, who drew attention at its first tick, and the method's reason.

    Raises:
        InputError: the bag is unusable, or the world differs from the recorded one.
        SimulationError: SUMO failed.
    """
    reader = BagReader(bag)
    plan, ticks = read_plan(reader), BagTicks(reader)
    then = recorded_result(ticks, plan)
    first: dict[float, Repair] = {
        tick.stamp * 1e-9: tick.repair for tick in ticks if tick.repair is not None and tick.repair.intervened
    }
    played = Switchover(ticks, make_repairer("none"), then.duration + 1.0)
    with Console(stderr=True).status(f"{plan.scenario.name}: {futures} futures of {len(then.spells)} interventions"):
        result = run_with_need(plan.scenario, make_policy(plan.policy), played, futures)
    return [
        {
            "begin": spell.begin,
            "ticks": spell.ticks,
            "dose": spell.dose,
            "need": spell.need,
            "duration": spell.end - spell.begin,
            "verdict": _verdict(spell.need or 0.0),
            "objects": [trigger.object_id for trigger in first[spell.begin].triggers],
            "reason": first[spell.begin].reason,
        }
        for spell in result.spells
    ]


def _verdict(share: float) -> str:
    return "rescue" if share >= _RESCUE else "needless" if share < NEEDLESS else "in doubt"
