"""Repair methods by name, and the one door through which they are made."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import check_parameters
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.gated import GatedRepair
from roadmend.repair.governor import GovernorRepair
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.method import RepairMethod
from roadmend.repair.none import NoRepair
from roadmend.repair.parameters import (
    AdreftParameters,
    GatedParameters,
    GovernorParameters,
    GuardParameters,
    ModelParameters,
    NoParameters,
    PredictiveParameters,
    RandomParameters,
    RssParameters,
    RuleParameters,
)
from roadmend.repair.predictive import PredictiveRepair
from roadmend.repair.random import RandomRepair
from roadmend.repair.rss import RssRepair
from roadmend.repair.rule import RuleRepair
from roadmend.repair.self_oracle import ModelRepair


@dataclass(frozen=True, slots=True)
class MethodEntry:
    """How a method is made."""

    parameters: type[Parameters]
    make: Callable[[Any, int], RepairMethod]  # from an instance of ``parameters`` and a seed


METHODS: dict[str, MethodEntry] = {
    "none": MethodEntry(NoParameters, lambda _parameters, _seed: NoRepair()),
    "random": MethodEntry(RandomParameters, RandomRepair),
    "governor": MethodEntry(GovernorParameters, lambda parameters, _seed: GovernorRepair(parameters)),
    "rule": MethodEntry(RuleParameters, lambda parameters, _seed: RuleRepair(parameters)),
    "rss": MethodEntry(RssParameters, lambda parameters, _seed: RssRepair(parameters)),
    "predictive": MethodEntry(PredictiveParameters, lambda parameters, _seed: PredictiveRepair(parameters)),
    "model": MethodEntry(ModelParameters, lambda parameters, _seed: ModelRepair(parameters)),
    "adreft": MethodEntry(AdreftParameters, AdreftRepair),
    "gated": MethodEntry(GatedParameters, lambda parameters, _seed: GatedRepair(parameters)),
}


def make_repairer(
    name: str,
    parameters: Mapping[str, Any] | None = None,
    seed: int = 0,
    guard: Mapping[str, Any] | None = None,
) -> GuardedRepairer:
    """The method called ``name`` behind the guard.

    Args:
        name: a key of METHODS.
        parameters: what differs from the method's defaults.
        seed: for methods that draw numbers.
        guard: what differs from the guard's defaults (GuardParameters).

    Raises:
        InputError: the method is not available, or a parameter is unknown or out of range.
    """
    return GuardedRepairer(make_method(name, parameters, seed), check_parameters(guard, GuardParameters, "guard"))


def make_method(name: str, parameters: Mapping[str, Any] | None = None, seed: int = 0) -> RepairMethod:
    """The method called ``name`` alone, which nothing may be driven with.

    Raises:
        InputError: the method is not available, or a parameter is unknown or out of range.
    """
    entry = METHODS.get(name)
    if entry is None:
        raise InputError("repair method", f"'{name}' is not available", f"choose one of: {', '.join(METHODS)}")
    return entry.make(check_parameters(parameters, entry.parameters, name), seed)
