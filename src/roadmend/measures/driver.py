"""Who drives: the part of every kept episode's key that a policy and a repair method have in common."""

from collections.abc import Mapping
from typing import Any

from roadmend.core.journal import Key, entry_key
from roadmend.policies.registry import POLICY_REGISTRY, make_policy
from roadmend.repair.registry import METHOD_REGISTRY, make_method, make_repairer
from roadmend.world.runner import run_episode


def driver_key(policy: str, method: str = "none", parameters: Mapping[str, Any] | None = None) -> Key:
    """Digest of everything but the scenario that decides an episode: code, models and parameters, wherever they lie.

    Args:
        policy: as it was asked for, see ``policies.registry``.
        method: the repair method, as it was asked for.
        parameters: what differs from the method's defaults.

    Raises:
        InputError: there is no such policy, model file or method, or a parameter is unusable.
    """
    driver, made = make_policy(policy), make_method(method, parameters)
    drives, repairs = POLICY_REGISTRY.find(policy), METHOD_REGISTRY.find(method)
    model = getattr(driver, "model_digest", None)
    given = {name: value for name, value in (parameters or {}).items() if name != "model"}  # a place; see the digest
    return entry_key(
        [
            *(type(driver).__module__, type(made).__module__, *drives.modules, *repairs.modules),
            *(make_repairer.__module__, run_episode.__module__),
        ],
        driver.name if model else policy,  # without a model, the registered name says with which settings it is made
        model,
        method if repairs.is_foreign else repairs.label,  # a model file goes by what is in it
        given,
        getattr(getattr(made, "model", None), "digest", None) or getattr(made, "model_digest", None),
    )
