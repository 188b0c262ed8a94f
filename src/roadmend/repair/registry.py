"""Repair methods, ours by name and those of others, and the one door through which they are made."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.foreign import ForeignClass, check_answers
from roadmend.core.parameters import NoParameters, Parameters, with_defaults
from roadmend.core.registry import Registry
from roadmend.core.settings import check_parameters
from roadmend.networks.checkpoint import SUFFIX, find_model, model_kind
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.foreign import ForeignMethod
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

_MODELS = {"adreft": "adreft", "self_oracle": "model"}  # the method that a kind of model is for


def _of_class(given: str, thing: Any) -> MethodEntry:
    found = ForeignClass.check(f"repair method {given}", thing, RepairMethod, ["parameters", "seed"])

    def make(parameters: Parameters, seed: int) -> RepairMethod:
        if found.is_new():
            check_answers(
                f"repair method {given}", ForeignMethod(given, found.make(parameters=parameters, seed=seed)).answer
            )
        return ForeignMethod(given, found.make(parameters=parameters, seed=seed))

    return MethodEntry(found.parameters, make)


def _of_model(given: str) -> tuple[str, MethodEntry] | None:
    if not given.endswith(SUFFIX):
        return None
    kind = model_kind(find_model(given))
    if kind not in _MODELS:
        raise InputError(given, f"is a model of the kind {kind!r}, which does not repair", "give one of ADReFT")
    method = _MODELS[kind]
    entry = METHODS[method]
    return method, MethodEntry(with_defaults(entry.parameters, model=given), entry.make)


METHOD_REGISTRY = Registry(
    "repair method", "roadmend.repairs", METHODS, _of_class, _of_model, "a model file of ADReFT (.safetensors)"
)


def of_vehicle(label: str, entry: MethodEntry, full_brake: float) -> dict[str, float]:
    """Parameters that a method takes from the vehicle: of one of ours that reckons with it, how hard it brakes.

    Args:
        label: of the method.
        entry: of the method.
        full_brake: deceleration at brake 1 [m/s2].
    """
    reckons = label in METHODS and "full_brake" in entry.parameters.model_fields
    return {"full_brake": full_brake} if reckons else {}


def make_repairer(
    name: str,
    parameters: Mapping[str, Any] | None = None,
    seed: int = 0,
    guard: Mapping[str, Any] | None = None,
) -> GuardedRepairer:
    """A method behind the guard.

    Args:
        name: of ours or of an installed package's, ``package.module:Class``, or a model file.
        parameters: what differs from the method's defaults.
        seed: for methods that draw numbers.
        guard: what differs from the guard's defaults (GuardParameters).

    Raises:
        InputError: the method is not available, or a parameter is unknown or out of range.
    """
    return GuardedRepairer(make_method(name, parameters, seed), check_parameters(guard, GuardParameters, "guard"))


def make_method(name: str, parameters: Mapping[str, Any] | None = None, seed: int = 0) -> RepairMethod:
    """A method alone, which nothing may be driven with.

    Raises:
        InputError: the method is not available, or a parameter is unknown or out of range.
    """
    found = METHOD_REGISTRY.find(name)
    return found.entry.make(check_parameters(parameters, found.entry.parameters, found.label), seed)
