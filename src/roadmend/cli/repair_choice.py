"""Which repair method, and how it is set: options that commands share."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import yaml

from roadmend.core.errors import InputError
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.registry import METHODS, make_repairer


@dataclass(frozen=True, slots=True)
class RepairChoice:
    """A repair method as the command line names it."""

    method: str
    parameters: dict[str, Any]
    seed: int

    def make(self) -> GuardedRepairer:
        """The method behind its guard.

        Raises:
            InputError: a parameter is unknown or out of range, or a model cannot be used.
        """
        return make_repairer(self.method, self.parameters, self.seed)

    def provenance(self) -> dict[str, str]:
        """What a bag says about it."""
        return {"method": self.method, "parameters": json.dumps(self.parameters), "seed": str(self.seed)}


def repair_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options --repair, --set, --model and --seed, whose values ``read_choice`` takes."""
    for option in (
        click.option(
            "--seed",
            type=click.IntRange(0, 2**31 - 1),
            default=0,
            show_default=True,
            help="Seed of repair methods that draw numbers.",
        ),
        click.option(
            "--model", type=click.Path(path_type=Path), help="Model file of the method; short for --set model=FILE."
        ),
        click.option(
            "--set",
            "settings",
            multiple=True,
            metavar="NAME=VALUE",
            help="Parameter of the method (see config/repair); may be repeated.",
        ),
        click.option("--repair", "method", required=True, type=click.Choice(sorted(METHODS))),
    ):
        command = option(command)
    return command


def read_choice(method: str, settings: tuple[str, ...], model: Path | None, seed: int) -> RepairChoice:
    """The choice that the options make.

    Raises:
        InputError: a setting is no NAME=VALUE.
    """
    parameters: dict[str, Any] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        try:
            value = yaml.safe_load(text)
        except yaml.YAMLError:
            value = None
        if not (name and equals) or value is None:
            raise InputError(f"--set {setting}", "is no NAME=VALUE", "write for example --set rho=0.4")
        parameters[name] = value
    if model is not None:
        parameters["model"] = str(model)
    return RepairChoice(method, parameters, seed)
