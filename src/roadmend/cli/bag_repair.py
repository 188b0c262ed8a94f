"""``roadmend bag resimulate``: another repair method on a recorded run, and how one is named."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import click
from rich.markup import escape
from rich.table import Table

from roadmend import __version__
from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import DROVE, METHOD_NAME, REPAIR_SEED, TUNED
from roadmend.cli.options import JSON, PATH, Number, options_of, setting_option
from roadmend.cli.output import OUTCOME_STYLES, Waiting, wide_console
from roadmend.core.bounds import ARGUMENT
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError
from roadmend.core.yaml_file import parse_yaml
from roadmend.measures.fitting import fitting, fitting_account
from roadmend.policies.registry import POLICIES, make_policy
from roadmend.recording import topics
from roadmend.recording.episode_recorder import EpisodeRecorder, account_of
from roadmend.recording.layout import RECORD
from roadmend.recording.new_bag import new_bag
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import read_plan, recorded_result
from roadmend.recording.resimulation import Switchover
from roadmend.recording.ticks import BagTicks
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.registry import METHOD_REGISTRY, make_repairer, of_vehicle
from roadmend.world.road_network import LaneMap
from roadmend.world.runner import run_episode


@dataclass(frozen=True, slots=True)
class RepairChoice:
    """A repair method as the command line names it."""

    method: str
    parameters: dict[str, Any]
    seed: int

    def make(self, **guard: Any) -> GuardedRepairer:
        """The method behind its guard; ``guard`` is what differs from that one's defaults.

        Raises:
            InputError: a parameter is unknown or out of range, or a model cannot be used.
        """
        return make_repairer(self.method, self.parameters, self.seed, guard)

    def braking(self, full_brake: float) -> "RepairChoice":
        """The choice for a vehicle with this deceleration at full brake [m/s2], where it says nothing else."""
        found = METHOD_REGISTRY.find(self.method)
        return replace(self, parameters=of_vehicle(found.label, found.entry, full_brake) | self.parameters)

    def behind(self, policy: str) -> "RepairChoice":
        """The choice with the model and the settings that were made for a policy, where it says nothing else.

        Args:
            policy: as a bag names it; code from outside and nodes of somebody else's leave the defaults.
        """
        fitted = fitting(self.method, policy) if policy in POLICIES else {}
        return replace(self, parameters=fitted | self.parameters)

    def account(self, policy: str) -> str:
        """One line for people: whether what it runs with was made for a policy, and if not, for whom.

        Args:
            policy: as a bag names it; empty of code from outside and of nodes of somebody else's.

        Raises:
            InputError: its model cannot be read.
        """
        if policy not in POLICIES:
            return ""
        known = METHOD_REGISTRY.find(self.method).entry.parameters().model_dump() | self.parameters
        return fitting_account(self.method, policy, known)

    def provenance(self) -> dict[str, str]:
        """What a bag says about it."""
        return {"method": self.method, "parameters": json.dumps(self.parameters), "seed": str(self.seed)}


@dataclass(frozen=True)
class RepairOptions:
    """The repair method, its parameters and its seed."""

    method: Annotated[str, click.option("--repair", "method", required=True, type=METHOD_NAME)]
    settings: Annotated[
        tuple[str, ...],
        setting_option("Parameter of the method (see config/repair)"),
    ]
    model: Annotated[
        Path | None, click.option("--model", type=PATH, help="Model file of the method; short for --set model=FILE.")
    ]
    seed: Annotated[int, REPAIR_SEED]
    tuned: Annotated[bool, TUNED]


def read_choice(given: RepairOptions, policy: str) -> RepairChoice:
    """The choice that the options make behind a policy.

    Raises:
        InputError: a setting is no NAME=VALUE, or what was made for the policy is damaged.
    """
    parameters: dict[str, Any] = {}
    for setting in given.settings:
        name, equals, text = setting.partition("=")
        try:
            value = parse_yaml(text, name, ARGUMENT)
        except InputError:
            value = None
        if not (name and equals) or value is None:
            raise InputError(f"--set {setting[:100]}", "is no NAME=VALUE", "write for example --set rho=0.4")
        parameters[name] = value
    if given.model is not None:
        parameters["model"] = str(given.model)
    choice = RepairChoice(given.method, parameters, given.seed)
    return choice.behind(policy) if given.tuned else choice


def tell_choice(given: RepairOptions, choice: RepairChoice, policy: str) -> None:
    """Say on standard error, as 'run' and 'evaluate' do, for whom the model and the settings were made.

    Raises:
        InputError: the model cannot be read.
    """
    if given.tuned and (account := choice.account(policy)):
        click.echo(account, err=True)


def driver_of(bag: Path) -> str:
    """The policy that a bag names; empty where it names none.

    Raises:
        InputError: the bag cannot be read.
    """
    return BagReader(bag).metadata.get(RECORD, {}).get("policy", "")


_FIGURES = ("method", "outcome", "text", "duration", "min_distance", "interventions")  # that are shown of a run


@click.command(
    cls=ExampleCommand,
    examples=["roadmend bag resimulate bags/my-run --repair adreft --from-time 10 --out bags/my-run-adreft"],
)
@click.argument("bag", type=PATH)
@options_of(RepairOptions)
@click.option(
    "--from-time",
    default=0.0,
    show_default=True,
    type=Number(0.0),
    help="Simulation time [s] at which the method takes over; until then the recorded commands are driven.",
)
@DROVE
@click.option("--out", required=True, type=PATH, help="Folder of the new bag.")
@JSON
def resimulate(bag: Path, given: RepairOptions, from_time: float, policy: str, out: Path, *, as_json: bool) -> None:
    """Drive the scenario of a recorded run again, with another repair method from the start or from a moment on.

    Until that moment the run must repeat itself bit for bit, or the command ends with what differs.
    """
    driver = policy or driver_of(bag)
    choice = read_choice(given, driver)
    then, now = resimulate_bag(bag, choice, from_time, out, policy)
    tell_choice(given, choice, driver)
    if as_json:
        content = {"then": _figures(then), "now": _figures(now), "from_time": from_time, "bag": str(out)}
        click.echo(json.dumps({**content, "choice": choice.provenance()}, indent=2))
    else:
        _show_outcomes({"then": then, "now": now}, {"then": bag, "now": out})


def resimulate_bag(
    bag: Path, choice: RepairChoice, from_time: float, out: Path, policy: str = ""
) -> tuple[EpisodeResult, EpisodeResult]:
    """Drive a run again and record it; returns what it came to then and now.

    Raises:
        InputError: the bag, the choice, the moment or the place of the new bag is unusable, or the world differs from
            the recorded one.
        RecordingError: the new bag cannot be written.
        SimulationError: SUMO failed.
    """
    reader = BagReader(bag)
    plan, ticks = read_plan(reader, policy), BagTicks(reader)
    then = recorded_result(ticks, plan)
    if not from_time <= then.duration:
        raise InputError("--from-time", f"{from_time:g} s is after the end", f"give 0 to {then.duration:g} s")
    switchover = Switchover(ticks, choice.make(), from_time, "drive from the start with --from-time 0")
    with new_bag(out) as writer, Waiting(f"{plan.scenario.name} · {choice.method}"):
        for attachment in reader.attachments.values():
            writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        methods = {False: plan.method, True: choice.method}
        recorder = EpisodeRecorder(writer, lambda time: methods[switchover.has_taken_over(time)], _lanes(ticks))
        now = run_episode(
            plan.scenario,
            make_policy(plan.policy, plan.policy_parameters),
            switchover,
            recorder.answered,
            recorder.ended,
            recorder.opened,
        )
        writer.add_metadata(
            RECORD,
            {
                "scenario_file": plan.scenario_file,
                "policy": plan.policy,
                "policy_parameters": json.dumps(plan.policy_parameters),
                **choice.provenance(),
                "roadmend": __version__,
                "resimulated_from": bag.name,
                "from_time": f"{from_time:g}",
                **account_of(now, writer.count),
            },
        )
    return then, now


def _lanes(ticks: BagTicks) -> LaneMap | None:
    """The map as it was recorded: the world is the same."""
    return next((tick.lanes for tick in ticks if tick.lanes is not None), None) if topics.MAP in ticks.topics else None


def _figures(result: EpisodeResult) -> dict[str, Any]:
    figures = result.figures()
    return {name: figures[name] for name in _FIGURES}


def _show_outcomes(outcomes: dict[str, EpisodeResult], bags: dict[str, Path]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("", "method", "outcome", "after"):
        table.add_column(title, no_wrap=True)
    for title in ("min\ndistance", "inter-\nventions"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("bag", overflow="fold")
    for when, one in outcomes.items():
        distance = "-" if one.min_distance is None else f"{one.min_distance:.2f} m"
        outcome = f"[{OUTCOME_STYLES.get(one.outcome.name, 'white')}]{one.outcome.name}[/]"
        after, bag = f"{one.duration:.2f} s", str(bags[when])
        table.add_row(when, escape(one.method), outcome, after, distance, str(one.interventions), escape(bag))
    wide_console().print(table)
