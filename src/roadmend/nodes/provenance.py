"""What a bag says about the run that made it: versions, configuration and the digests of the models that drove."""

import contextlib
import hashlib
import json
import re
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.registry import Registry
from roadmend.core.source_digest import source_digest
from roadmend.networks.checkpoint import find_model
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY

_VERSIONED = ("libsumo", "eclipse-sumo", "numpy", "mcap", "rosbags", "ros-jazzy-rclpy")
_PREFIXES = {"adreft": "adreft-", "model": "self_oracle-"} | dict.fromkeys(
    KINDS, ""
)  # of the shipped models of who has one


def provenance(scenario: Path, policy: str, method: str, clock: str, seed: int, given: Sequence[str]) -> dict[str, str]:
    """Named texts for the bag's metadata.

    Args:
        scenario: the scenario's file.
        policy: the policy's name.
        method: the repair method's name.
        clock: lockstep or realtime.
        seed: of the repair method.
        given: ROS arguments that every node gets; they win over the configuration's defaults.
    """
    known = {"scenario_file": scenario.name, "policy": policy, "method": method, "clock": clock, "seed": str(seed)}
    known |= {"ros_arguments": " ".join(given), "roadmend": __version__, "python": sys.version.split()[0]}
    for package in _VERSIONED:
        with contextlib.suppress(PackageNotFoundError):
            known[package] = version(package)
    known |= _told_of("policy", POLICY_REGISTRY, policy, given)
    known |= _told_of("method", METHOD_REGISTRY, method, given)
    return known


def _told_of(role: str, registry: Registry[Any], name: str, given: Sequence[str]) -> dict[str, str]:
    """Parameters, model and source of who drives or repairs."""
    try:
        found = registry.find(name)
    except InputError:
        return {}  # the node refuses it anyway
    values = found.entry.parameters().model_dump()
    known = {f"{role}_defaults": json.dumps(values)}
    if found.label in _PREFIXES:
        model = _override(f"{found.label}.model", given) or str(values["model"])
        known[f"{role}_model"], known[f"{role}_model_sha256"] = model, _digest(model, _PREFIXES[found.label])
    if found.is_foreign:
        known[f"{role}_origin"] = found.origin
        with contextlib.suppress(InputError):  # code without a source has no digest
            known[f"{role}_code_sha256"] = source_digest(found.modules)
    return known


def _override(name: str, given: Sequence[str]) -> str:
    """The value that ROS arguments give to a parameter, on any node; empty if they do not."""
    pattern = re.compile(rf"(?:[^:=]*:)?{re.escape(name)}:=['\"]?([^'\"]*)['\"]?")
    found = [match[1] for match in map(pattern.fullmatch, given) if match]
    return found[-1] if found else ""


def _digest(model: str, prefix: str) -> str:
    """SHA-256 of a model's file, as load_checkpoint has it; empty where the node will refuse the model anyway."""
    try:
        return hashlib.sha256(find_model(model, prefix).read_bytes()).hexdigest()
    except (InputError, OSError):
        return ""
