"""The driving policies: ours by name, and those of others."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.foreign import ForeignClass, check_answers
from roadmend.core.interfaces import Policy
from roadmend.core.parameters import Parameters, with_defaults
from roadmend.core.registry import Registry
from roadmend.core.settings import check_parameters
from roadmend.networks.checkpoint import SUFFIX, find_model, model_kind
from roadmend.policies.foreign import ForeignPolicy
from roadmend.policies.modular import ModularPolicy
from roadmend.policies.neural import NeuralParameters, NeuralPolicy
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.parameters import ModularParameters


@dataclass(frozen=True, slots=True)
class PolicyEntry:
    """How a policy is made."""

    parameters: type[Parameters]
    make: Callable[[Any], Policy]  # from an instance of ``parameters``


def _neural(kind: str, model: str) -> PolicyEntry:
    return PolicyEntry(
        with_defaults(NeuralParameters, model=model), lambda parameters: NeuralPolicy(parameters.path, kind)
    )


POLICIES: dict[str, PolicyEntry] = {
    "modular": PolicyEntry(ModularParameters, ModularPolicy),
    **{kind: _neural(kind, kind) for kind in KINDS},
}


def _of_class(given: str, thing: Any) -> PolicyEntry:
    found = ForeignClass.check(f"policy {given}", thing, Policy, ["parameters"])

    def make(parameters: Parameters) -> ForeignPolicy:
        if found.is_new():
            check_answers(f"policy {given}", ForeignPolicy(given, found.make(parameters=parameters)).answer)
        return ForeignPolicy(given, found.make(parameters=parameters))

    return PolicyEntry(found.parameters, make)


def _of_model(given: str) -> tuple[str, PolicyEntry] | None:
    if not given.endswith(SUFFIX):
        return None
    kind = model_kind(find_model(given))
    if kind not in KINDS:
        raise InputError(given, f"is a model of the kind {kind!r}, which does not drive", "give a neural policy's")
    return kind, _neural(kind, given)


POLICY_REGISTRY = Registry(
    "policy", "roadmend.policies", POLICIES, _of_class, _of_model, "a neural policy's model file (.safetensors)"
)


def make_policy(given: str, parameters: Mapping[str, Any] | None = None) -> Policy:
    """A policy by name, as ``package.module:Class``, or by its model file; ``parameters`` replace single defaults.

    Raises:
        InputError: there is none, it cannot be used, or a parameter is unknown or out of range.
    """
    found = POLICY_REGISTRY.find(given)
    return found.entry.make(check_parameters(parameters, found.entry.parameters, f"policy.{found.label}"))
