"""What a bag says about the run that made it: versions, configuration and the digests of the models that drove."""

import contextlib
import hashlib
import json
import re
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.networks.checkpoint import find_model
from roadmend.policies.neural import NeuralParameters
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.parameters import ModularParameters
from roadmend.repair.registry import METHODS

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
    for role, name, parameters in (
        ("policy", policy, _policy_parameters(policy)),
        ("method", method, METHODS[method].parameters() if method in METHODS else None),
    ):
        if parameters is not None:
            values = parameters.model_dump()
            known[f"{role}_defaults"] = json.dumps(values)
            if name in _PREFIXES:
                model = _override(f"{name}.model", given) or str(values["model"])
                known[f"{role}_model"], known[f"{role}_model_sha256"] = model, _digest(model, _PREFIXES[name])
    return known


def _policy_parameters(policy: str) -> Parameters | None:
    if policy in KINDS:
        return NeuralParameters.of(policy)
    return ModularParameters() if policy == "modular" else None


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
