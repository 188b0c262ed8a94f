"""The driving policies by name."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.interfaces import Policy
from roadmend.core.settings import check_parameters
from roadmend.networks.checkpoint import SUFFIX, find_model
from roadmend.policies.modular import ModularPolicy
from roadmend.policies.neural import NeuralParameters, NeuralPolicy
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.parameters import ModularParameters

Values = Mapping[str, Any]


def _modular(values: Values) -> Policy:
    return ModularPolicy(check_parameters(values, ModularParameters, "policy.modular"))


def _neural(kind: str, values: Values) -> Policy:
    return NeuralPolicy(NeuralParameters.of(kind, values).path, kind)


POLICIES: dict[str, Callable[[Values], Policy]] = {
    "modular": _modular,
    **{kind: partial(_neural, kind) for kind in KINDS},
}


def make_policy(name: str, parameters: Values | None = None) -> Policy:
    """A policy by name, or the neural one of a model file; ``parameters`` replace single defaults.

    Raises:
        InputError: there is no such policy or file, or a parameter is unknown or out of range.
    """
    if name.endswith(SUFFIX):
        return NeuralPolicy(find_model(name))
    if name not in POLICIES:
        raise InputError(
            "policy", f"there is no {name!r}", f"choose one of {', '.join(POLICIES)}, or give a model file"
        )
    return POLICIES[name](parameters or {})
