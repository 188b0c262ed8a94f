"""Scenarios as a user gives them: one that is loaded already, or the path of a file."""

from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.world import scenario_file
from roadmend.world.scenario import Scenario

ScenarioLike = Scenario | str | PathLike[str]


def load_scenario(path: str | PathLike[str]) -> Scenario:
    """Read a scenario; files that it names become absolute paths.

    Args:
        path: of a YAML file, as ``roadmend sample`` makes it.

    Raises:
        InputError: the file is missing, is no YAML, or a field of it is unusable.
    """
    return scenario_file.load_scenario(Path(path))


def load_scenarios(*paths: str | PathLike[str]) -> list[Scenario]:
    """Read scenarios from files, and from folders all that lie in them, in the order of their names.

    Raises:
        InputError: a file is missing or unusable, a folder holds none, or two scenarios have one name.
    """
    return scenario_file.load_scenarios([Path(path) for path in paths])


def scenario_of(given: object) -> Scenario:
    """A scenario as it is, or read from its file.

    Raises:
        InputError: see ``load_scenario``; or it is neither.
    """
    if isinstance(given, Scenario):
        return given
    if isinstance(given, str | PathLike):
        return load_scenario(given)
    what = f"is neither a Scenario nor a path, but {type(given).__name__}"
    raise InputError("scenario", what, "see roadmend.load_scenario and roadmend.sample_scenario")


def scenarios_of(given: ScenarioLike | Sequence[ScenarioLike]) -> list[Scenario]:
    """One or several, each with a name of its own.

    Raises:
        InputError: one is unusable, there is none, or two have one name.
    """
    several = [*given] if isinstance(given, Iterable) and not isinstance(given, Scenario | str | PathLike) else [given]
    found = [scenario_of(each) for each in several]
    if not found:
        raise InputError("scenarios", "there is none", "give one at least")
    names = [scenario.name for scenario in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError("scenarios", f"two have the name {twice!r}", "give each scenario a name of its own")
    return found
