"""Who drives and who repairs, as a user gives them: by name, as a class, or as an object that is made already."""

import sys
from collections.abc import Mapping
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.foreign import check_answers, check_object
from roadmend.core.interfaces import Policy
from roadmend.core.settings import check_parameters
from roadmend.core.whole_number import whole_number
from roadmend.policies.foreign import ForeignPolicy
from roadmend.policies.registry import POLICY_REGISTRY, make_policy
from roadmend.repair.foreign import ForeignMethod
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.method import RepairMethod
from roadmend.repair.registry import METHOD_REGISTRY, make_method

PolicyLike = str | type[Policy] | Policy
RepairLike = str | type[RepairMethod] | RepairMethod
Settings = Mapping[str, Any]


def policy_of(given: PolicyLike, parameters: Settings | None = None) -> Policy:
    """A policy that can be driven with, after the checks that every one from outside undergoes.

    Args:
        given: a name as ``roadmend list policies`` has it, ``package.module:Class`` or a model file; a class; or an
            object, which is driven with as it is.
        parameters: what differs from its defaults; not of an object.

    Raises:
        InputError: there is none, it lacks something, cannot answer a plain scene, or a parameter is unusable.
    """
    parameters = settings_of("parameters", parameters)
    if isinstance(given, str):
        return make_policy(given, parameters)
    name = title_of(given)
    where = f"policy {name}"
    if isinstance(given, type):
        entry = POLICY_REGISTRY.adapt(name, given)
        return entry.make(check_parameters(parameters, entry.parameters, where))
    _refuse_parameters(where, parameters)
    check_object(where, given, Policy)
    policy = ForeignPolicy(name, given)
    check_answers(where, policy.answer)
    return policy


def repairer_of(given: RepairLike, parameters: Settings | None = None, seed: int = 0) -> GuardedRepairer:
    """A repair method behind the guard; see ``method_of``.

    Raises:
        InputError: as there.
    """
    return GuardedRepairer(method_of(given, parameters, seed))


def method_of(given: RepairLike, parameters: Settings | None = None, seed: int = 0) -> RepairMethod:
    """A repair method, after the checks that every one from outside undergoes; nothing is driven with it alone.

    Args:
        given: a name as ``roadmend list methods`` has it, ``package.module:Class`` or a model file; a class; or an
            object, which repairs as it is.
        parameters: what differs from its defaults; not of an object.
        seed: for methods that draw numbers; not for an object.

    Raises:
        InputError: there is none, it lacks something, cannot answer a plain scene, or a parameter or the seed is unusable.
    """
    seed, parameters = whole_number("seed", seed), settings_of("parameters", parameters)
    if isinstance(given, str):
        return make_method(given, parameters, seed)
    name = title_of(given)
    where = f"repair method {name}"
    if isinstance(given, type):
        entry = METHOD_REGISTRY.adapt(name, given)
        return entry.make(check_parameters(parameters, entry.parameters, where), seed)
    _refuse_parameters(where, parameters)
    check_object(where, given, RepairMethod)
    method = ForeignMethod(name, given)
    check_answers(where, method.answer)
    return method


def settings_of(where: str, given: object) -> dict[str, Any]:
    """Parameters by name; none where nothing was given.

    Raises:
        InputError: it is no mapping.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        what = f"is no dictionary of values by name, but {type(given).__name__}"
        raise InputError(where, what, 'give for instance {"model": "mine.safetensors"}')
    return dict(given)


def title_of(given: object) -> str:
    """What it is called in tables and bags: its name, or ``package.module:Class`` of a class and of an object of it."""
    if isinstance(given, str):
        return given
    kind = given if isinstance(given, type) else type(given)
    return f"{kind.__module__}:{kind.__qualname__}"


def name_of(given: object) -> str:
    """The name by which any process finds it again, or an empty text.

    An object has none, nor has a class that stands in a function or in no file, as in a notebook.
    """
    if isinstance(given, str):
        return given
    if not isinstance(given, type):
        return ""
    module = sys.modules.get(given.__module__)
    thing: object = module
    for part in given.__qualname__.split("."):
        thing = getattr(thing, part, None)
    return title_of(given) if thing is given and getattr(module, "__file__", None) else ""


def _refuse_parameters(where: str, parameters: Settings | None) -> None:
    if parameters:
        raise InputError(where, "is an object, which has its parameters", "give its class, or no parameters")
