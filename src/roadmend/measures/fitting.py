"""Which model and settings of a repair method belong to a policy: those that were trained and tuned behind it."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.core.settings import read_settings
from roadmend.networks.checkpoint import SUFFIX, find_model, load_checkpoint, model_kind
from roadmend.policies.registry import POLICIES, POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY

_PREFIXES = {"adreft": "adreft-", "gated": "adreft-", "model": "self_oracle-"}  # of the shipped models of who has one
_OUTSIDE = "external"  # a policy in a node of its own


class TunedMethod(BaseModel):
    """A method's best parameters; what they came to stands beside them in the file."""

    parameters: dict[str, Any]


class TunedMethods(BaseModel):
    """What 'roadmend train rivals' has found: config/repair/tuned/*.yaml. The file also says how."""

    methods: dict[str, TunedMethod]
    policy_model: str | None = None  # SHA-256 of the model that the policy drove with, if it has one


@dataclass(frozen=True, slots=True)
class _Driver:
    """A policy as far as something can have been made for it."""

    given: str
    label: str  # of ours; empty for code from outside
    digest: str  # SHA-256 of its model's file, empty for a policy without one


def fitting(method: str, policy: str) -> dict[str, Any]:
    """Parameters of a method that belong to a policy, where its defaults do not.

    Args:
        method: as it was asked for, see ``repair.registry``.
        policy: as it was asked for, see ``policies.registry``, or "external"; its code is not imported.

    Returns:
        By the names of the method's fields; empty where nothing was made for the policy.

    Raises:
        InputError: there is no such method or policy, or a file of settings is damaged.
    """
    found, driver = METHOD_REGISTRY.find(method), _driver(policy)
    if found.is_foreign or not driver.label:
        return {}
    fitted = dict(_tuned(found.label, driver))
    if found.label in _PREFIXES:
        fitted.pop("model", None)
        is_named = found.given != found.label  # a model file that was named stays
        if not is_named and _has_model(driver.label, _PREFIXES[found.label]):
            fitted["model"] = driver.label
    return fitted


def driver_of(policy: str, parameters: Mapping[str, Any]) -> str:
    """What to ask ``fitting`` for: the model that a policy's parameters name instead of the one that ships.

    Args:
        policy: as it was asked for.
        parameters: what differs from its defaults.

    Raises:
        InputError: there is no such model.
    """
    is_ours = policy.endswith(SUFFIX) or (policy in POLICIES and "model" in POLICIES[policy].parameters.model_fields)
    named = parameters.get("model") if is_ours else None
    if named is None or named in POLICIES:
        return named or policy
    return str(find_model(str(named)))


def fitting_accounts(policies: Sequence[str], methods: Sequence[str]) -> dict[str, dict[str, str]]:
    """By policy and method, what ``fitting_account`` says where the method runs with what ``fitting`` gives.

    Raises:
        InputError: as there.
    """
    found: dict[str, dict[str, str]] = {policy: {} for policy in policies}
    for policy, method in product(policies, methods):
        known = METHOD_REGISTRY.find(method).entry.parameters().model_dump() | fitting(method, policy)
        found[policy][method] = fitting_account(method, policy, known)
    return found


def fitting_account(method: str, policy: str, parameters: Mapping[str, Any]) -> str:
    """One line for people on what a method runs with: whether it was made for the policy, and if not, for whom.

    Args:
        method: as it was asked for.
        policy: as it was asked for.
        parameters: what the method was made with, after all overrides.

    Returns:
        Empty where nothing is ever made for a policy, as for a method from outside.

    Raises:
        InputError: as ``fitting``, or the model cannot be read.
    """
    found, driver = METHOD_REGISTRY.find(method), _driver(policy)
    if found.is_foreign:
        return ""
    said = []
    if found.label in _PREFIXES:
        said.append(_model_account(str(parameters["model"]), _PREFIXES[found.label], driver))
    tuned = {name: value for name, value in _tuned(found.label, driver).items() if name != "model"}
    if tuned:
        instead = {name: parameters[name] for name, value in tuned.items() if parameters.get(name) != value}
        words = f"settings tuned for it ({_listed(tuned)})"
        said.append(words if not instead else f"{words}, but given {_listed(instead)}")
    elif found.label in _tunable():
        said.append("its default settings, since none were tuned for it")
    return f"{found.label} behind {policy}: {'; '.join(said)}" if said else ""


def _model_account(model: str, prefix: str, driver: _Driver) -> str:
    made_for, digest = _maker(find_model(model, prefix))
    if driver.label and (made_for, digest) == (driver.label, driver.digest):
        return f"model {model}, made for it"
    whose = f"made for {made_for}" if made_for != driver.label else f"made for another model of {made_for}"
    is_there = bool(driver.label) and made_for != driver.label and _has_model(driver.label, prefix)
    return f"model {model}, {whose}{'' if is_there else ', since none was made for it'}"


def _driver(given: str) -> _Driver:
    if given in POLICIES:
        named = getattr(POLICIES[given].parameters(), "model", None)
        return _Driver(given, given, _digest(find_model(named)) if named else "")
    if given.endswith(SUFFIX):
        path = find_model(given)
        return _Driver(given, model_kind(path), _digest(path))
    if given == _OUTSIDE or ":" in given or given in POLICY_REGISTRY.names:
        return _Driver(given, "", "")
    POLICY_REGISTRY.find(given)  # says what is near
    return _Driver(given, "", "")


def _digest(path: Path) -> str:
    return _digest_as_of(path, path.stat().st_mtime_ns)


@cache
def _digest_as_of(path: Path, _changed_ns: int) -> str:
    """Searches ask at every scenario."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _has_model(label: str, prefix: str) -> bool:
    try:
        find_model(label, prefix)
    except InputError:
        return False
    return True


def _maker(path: Path) -> tuple[str, str]:
    """The policy that a model of a method was trained behind, and the SHA-256 of that policy's model or nothing."""
    header = load_checkpoint(path).header
    configuration, data = header.get("configuration", {}), header.get("data", {})
    digest = data.get("policy") or configuration.get("policy_model") or ""
    return str(configuration.get("policy", "another policy")), str(digest)


def _tuned(method: str, driver: _Driver) -> Mapping[str, Any]:
    """Settings that were tuned behind just this policy."""
    file = config_folder() / "repair" / "tuned" / f"{driver.label}.yaml"
    if not driver.label or not file.is_file():
        return {}
    content = _read(file)
    entry = content.methods.get(method)
    if entry is None or (content.policy_model or "") != driver.digest:
        return {}
    return entry.parameters


@cache
def _tunable() -> frozenset[str]:
    """Methods that are tuned for any policy at all."""
    files = (config_folder() / "repair" / "tuned").glob("*.yaml")
    return frozenset(name for file in files for name in _read(file).methods)


@cache
def _read(file: Path) -> TunedMethods:
    return read_settings(file, TunedMethods, "see 'roadmend train rivals --help'")


def _listed(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())
