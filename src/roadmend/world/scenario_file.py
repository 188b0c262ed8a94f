"""Scenarios on disk: YAML in, YAML out, errors in one line."""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from roadmend.core.bounded_file import opened
from roadmend.core.errors import InputError
from roadmend.core.settings import check_settings
from roadmend.core.whole_file import write_text
from roadmend.core.yaml_file import read_yaml
from roadmend.world.lone_network import with_traffic
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_networks import NetworkFile, SumoConfiguration
from roadmend.world.time_limit import time_for_route
from roadmend.world.user_configuration import WANTED, configurations_in, content_of, network_of

_SENSING_RANGE = 150.0  # [m] as in the scenario families on a clear day
SUFFIXES = frozenset({".yaml", ".yml"})


def load_scenario(path: Path) -> Scenario:
    """Read a scenario; files it names become absolute paths.

    Raises:
        InputError: the file is missing, is no YAML, or a field of it is unusable.
    """
    content = read_yaml(path, "give the path of a scenario; 'roadmend sample' makes one")
    if not isinstance(content, Mapping):
        raise InputError(str(path), "holds no fields", "see 'roadmend schema' for what a scenario has")
    scenario = parse_scenario(content, str(path))
    return _with_absolute_paths(scenario, path.parent)


def load_scenarios(paths: Iterable[Path]) -> list[Scenario]:
    """Read scenarios from files, and from folders all that lie in them.

    Raises:
        InputError: a file is missing or unusable, a folder holds none, or two scenarios have one name.
    """
    found: dict[str, Path] = {}
    scenarios = []
    for given in paths:
        files = sorted(each for each in given.iterdir() if each.suffix in SUFFIXES) if given.is_dir() else [given]
        if not files:
            raise InputError(str(given), "holds no scenario", "'roadmend sample' makes one")
        for path in files:
            scenario = load_scenario(path)
            if scenario.name in found:
                what = f"has the name {scenario.name!r}, as {found[scenario.name]} has"
                raise InputError(str(path), what, "give each scenario a name of its own")
            found[scenario.name] = path
            scenarios.append(scenario)
    return scenarios


def parse_scenario(content: Mapping[str, Any], where: str) -> Scenario:
    """Check plain data against the scenario model.

    Raises:
        InputError: names the first field at fault.
    """
    return check_settings(content, Scenario, where, "see 'roadmend schema' for what is allowed")


def scenario_of_configuration(
    path: Path, ego_route: Sequence[str], warm_up: float, time_limit: float | None = None, seed: int = 0
) -> Scenario:
    """A scenario in the traffic of a SUMO configuration, on a route that the user names.

    Args:
        path: of the .sumocfg file, or of a lone network.
        ego_route: edges; none: the longest route of the traffic's.
        warm_up: [s] of traffic before the ego enters.
        time_limit: [s] to drive; None: as the route asks for.
        seed: of the traffic.

    Raises:
        InputError: there is no such file, it has no such route, or a value is out of range.
    """
    if not path.is_file():
        raise InputError(str(path), "no such file", WANTED)
    path = with_traffic(path)
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", path.parent.resolve().name)
    content = {
        "name": name or "sumocfg",
        "seed": seed,
        "time_limit": Scenario.model_fields["time_limit"].default if time_limit is None else time_limit,
        "network": {"kind": "sumocfg", "path": str(path.resolve()), "warm_up": warm_up},
        "ego": {"route": [*ego_route], "speed": 0.0},
    }
    scenario = parse_scenario(content, str(path))
    if time_limit is not None or not ego_route:
        return scenario
    return scenario.model_copy(update={"time_limit": time_for_route(scenario)})


def drawn_scenarios(paths: Sequence[Path], seeds: Iterable[int], warm_up: float, time_limit: float) -> list[Scenario]:
    """Drives in the traffic of SUMO configurations: with each seed other traffic, another start and another route.

    Args:
        paths: of .sumocfg files, of lone networks, and of folders in which all configurations below are taken.
        seeds: of the drives on each.
        warm_up: [s] of traffic before the ego enters.
        time_limit: [s] to drive.

    Raises:
        InputError: there is no such file, it names none or a file that does not exist, or a value is out of range.
    """
    found: dict[str, Path] = {}
    scenarios = []
    for given, path in configurations_in([with_traffic(each) for each in paths]):
        name = re.sub(r"[^A-Za-z0-9_.-]", "_", given)
        if name in found:
            what = f"is called {name!r}, as {found[name]} is"
            raise InputError(str(path), what, "give it another name, or measure the two one after the other")
        found[name] = path
        place = path.resolve()  # of the file behind a link, beside which its others lie
        network_of(place)
        network = {"kind": "sumocfg", "path": str(place), "warm_up": warm_up, "draw": True}
        content = {
            "time_limit": time_limit,
            "network": network | {"content": content_of(place)},
            "ego": {},
            "environment": {"sensing_range": _SENSING_RANGE},
        }
        scenarios += [parse_scenario(content | {"name": f"{name}-{seed}", "seed": seed}, str(path)) for seed in seeds]
    return scenarios


def outside_content(scenario: Scenario) -> str | None:
    """SHA-256 of the files that a scenario's network lies in, hexadecimal; None where the scenario describes it itself.

    The scenario's own digest knows no more than their place. Files that cannot be read are told apart by the reason.
    """
    network = scenario.network
    try:
        if isinstance(network, SumoConfiguration):
            return content_of(Path(network.path))
        if isinstance(network, NetworkFile):
            with opened(Path(network.path), "give the path of a SUMO .net.xml file") as file:
                return hashlib.sha256(file.read()).hexdigest()
    except (InputError, OSError) as error:
        return hashlib.sha256(str(error).encode()).hexdigest()
    return None


def _with_absolute_paths(scenario: Scenario, base: Path) -> Scenario:
    network = scenario.network
    if isinstance(network, NetworkFile | SumoConfiguration):
        absolute = str((base / network.path).resolve())
        return scenario.model_copy(update={"network": network.model_copy(update={"path": absolute})})
    return scenario


def dump_scenario(scenario: Scenario) -> str:
    """The scenario as YAML text."""
    content = scenario.model_dump(mode="json", exclude_none=True)
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)


def save_scenario(scenario: Scenario, path: Path) -> None:
    """Write a scenario as YAML, complete or not at all.

    Raises:
        InputError: the place cannot be written.
    """
    write_text(path, dump_scenario(scenario))


def scenario_schema() -> dict[str, Any]:
    """JSON schema of a scenario file."""
    schema = Scenario.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
