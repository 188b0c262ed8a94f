"""Repair methods by name, and the one door through which they are made."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import ValidationError

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.method import RepairMethod
from roadmend.repair.none import NoRepair
from roadmend.repair.parameters import (
    AdreftParameters,
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

Model = TypeVar("Model", bound=Parameters)


@dataclass(frozen=True, slots=True)
class MethodEntry:
    """How a method is made."""

    parameters: type[Parameters]
    make: Callable[[Any, int], RepairMethod]  # from an instance of ``parameters`` and a seed


METHODS: dict[str, MethodEntry] = {
    "none": MethodEntry(NoParameters, lambda _parameters, _seed: NoRepair()),
    "random": MethodEntry(RandomParameters, RandomRepair),
    "rule": MethodEntry(RuleParameters, lambda parameters, _seed: RuleRepair(parameters)),
    "rss": MethodEntry(RssParameters, lambda parameters, _seed: RssRepair(parameters)),
    "predictive": MethodEntry(PredictiveParameters, lambda parameters, _seed: PredictiveRepair(parameters)),
    "model": MethodEntry(ModelParameters, lambda parameters, _seed: ModelRepair(parameters)),
    "adreft": MethodEntry(AdreftParameters, AdreftRepair),
}


def read_parameters(where: str, model: type[Model], values: Mapping[str, Any] | None) -> Model:
    """Parameters from plain values.

    Raises:
        InputError: a name is unknown or a value is out of its range or of the wrong type.
    """
    try:
        return model(**dict(values or {}))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or "parameters"
        if first["type"] == "extra_forbidden":
            known = ", ".join(model.model_fields) or "none"
            raise InputError(f"{where}.{field}", "unknown parameter", f"known are: {known}") from error
        meaning = model.model_fields[field].description if field in model.model_fields else "see the parameters"
        raise InputError(f"{where}.{field}", f"{first['msg']}, got {first['input']!r}", f"{meaning}") from error


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
    entry = METHODS.get(name)
    if entry is None:
        raise InputError("repair method", f"'{name}' is not available", f"choose one of: {', '.join(METHODS)}")
    method = entry.make(read_parameters(name, entry.parameters, parameters), seed)
    return GuardedRepairer(method, read_parameters("guard", GuardParameters, guard))
