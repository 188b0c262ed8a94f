"""What a run is made of: versions, and class, code and model of what drives or repairs, read off the objects themselves."""

import contextlib
import sys
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Any

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.registry import Found
from roadmend.core.source_digest import source_digest
from roadmend.networks.checkpoint import SUFFIX
from roadmend.policies.foreign import ForeignPolicy
from roadmend.repair.foreign import ForeignMethod

_VERSIONED = ("libsumo", "eclipse-sumo", "numpy", "mcap", "rosbags", "ros-jazzy-rclpy")
_MODEL, _THRESHOLD = ("model", "_model"), ("threshold", "_threshold")  # where methods keep them


def provenance(scenario: Path, given: Sequence[str]) -> dict[str, str]:
    """Named texts for the bag's metadata: what no node of the graph can tell of itself.

    Args:
        scenario: the scenario's file.
        given: ROS arguments that every node gets.
    """
    known = {"scenario_file": scenario.name, "ros_arguments": " ".join(given)}
    known |= {"roadmend": __version__, "python": sys.version.split()[0]}
    for package in _VERSIONED:
        with contextlib.suppress(PackageNotFoundError):
            known[package] = version(package)
    return known


def described(found: Found[Any], made: object, parameters: Mapping[str, Any]) -> dict[str, str]:
    """What drives or repairs, as it was made.

    Args:
        found: what the registry has found.
        made: the policy or method itself.
        parameters: what it was made with, by the fields' names.

    Returns:
        ``class`` and ``package``; where there is one, ``model`` (the name of its file, or what was given) with
        ``model_sha256``, and ``threshold``; of code from outside also ``origin`` and ``code_sha256``.
    """
    inner: object = made
    if isinstance(made, ForeignPolicy):
        inner = made.policy
    elif isinstance(made, ForeignMethod):
        inner = made.method
    kind = type(inner)
    known = {"class": f"{kind.__module__}.{kind.__qualname__}", "package": _package(kind.__module__)}
    model = _first(inner, _MODEL)
    digest = _first(model, ("digest",)) or _first(inner, ("model_digest",))
    if digest:
        named = parameters.get("model")
        known |= {"model": _model_name(named)} if named else {}
        known["model_sha256"] = str(digest)
    threshold = _first(inner, _THRESHOLD)
    if isinstance(threshold, float | int):
        known["threshold"] = repr(float(threshold))
    if found.is_foreign:
        known["origin"] = found.origin
        with contextlib.suppress(InputError):  # code without a source has no digest
            known["code_sha256"] = source_digest(found.modules)
    return known


def _first(thing: object, names: Iterable[str]) -> Any:
    """The first of some attributes that is there; one whose property raises is not."""
    for name in names:
        with contextlib.suppress(Exception):
            found = getattr(thing, name)
            if found is not None:
                return found
    return None


def _package(module: str) -> str:
    """Name and version of the package that a module comes with; the module's own name where none was installed."""
    root = module.partition(".")[0]
    if root == "roadmend":
        return f"roadmend {__version__}"
    names = packages_distributions().get(root, [])
    return f"{names[0]} {version(names[0])}" if names else f"{module}, not installed"


def _model_name(given: object) -> str:
    """A path as it was given, or the name of a model that ships with roadmend."""
    text = str(given)
    return str(Path(text).resolve()) if text.endswith(SUFFIX) else text
