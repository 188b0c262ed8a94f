"""What a built crash scenario looks like from above, and its run, as plain data that a page plays."""

import json
import math
from pathlib import Path
from typing import Any

from roadmend.core.bounds import TEXT
from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json
from roadmend.core.tick import INTERVAL
from roadmend.core.whole_file import write_text
from roadmend.safe.trial import CrashTestEpisode, Film
from roadmend.world.network import network_file
from roadmend.world.road_network import LaneKind, lanes_of, read_network
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

ENDING = ".film.json"
_FORMAT = "roadmend-crash-film/1"
_EVERY = 2  # ticks a frame: 10 a second
_REACH = 400.0  # [m] from the vehicles, beyond which no lane is drawn
_KINDS = {LaneKind.WALK: "walk", LaneKind.ROAD: "road", LaneKind.JUNCTION: "junction"}


def film_of(scenario: Scenario, film: Film, *, ego: str, collided: bool, text: str) -> dict[str, Any]:
    """A run as plain data: lanes, bodies and, ten times a second, where everybody is.

    Args:
        scenario: that was run.
        film: where everybody was; at least one tick.
        ego: what the vehicle in whose place the policy drove is called.
        collided: whether it ended with a contact, so that the last frame is its moment.
        text: how it ended.
    """
    names = [ego]
    for seen in film.names:
        names.extend(name for name in seen if name not in names)
    last = len(film.ego) - 1
    ticks = [*range(0, last, _EVERY), last]
    frames, bodies = [], dict.fromkeys(names, (4.5, 1.8))
    for tick in ticks:
        own, others, seen = film.ego[tick], film.objects[tick], film.names[tick]
        bodies[ego] = own.length, own.width
        places: list[list[float] | None] = [None] * len(names)
        places[0] = _pose(own.x, own.y, own.yaw)
        for index, name in enumerate(seen):
            places[names.index(name)] = _pose(others.x[index], others.y[index], others.yaw[index])
            bodies[name] = float(others.length[index]), float(others.width[index])
        frames.append([round(tick * INTERVAL, 2), places])
    vehicles = [
        {"name": name, "length": round(bodies[name][0], 2), "width": round(bodies[name][1], 2)} for name in names
    ]
    return {
        "format": _FORMAT,
        "scenario": scenario.name,
        "text": text,
        "collided": collided,
        "vehicles": vehicles,
        "frames": frames,
        "lanes": _lanes(scenario, [(ego.x, ego.y) for ego in film.ego]),
    }


def film_of_trial(scenario: Scenario, trial: CrashTestEpisode) -> dict[str, Any]:
    """The run of an episode that was driven."""
    summary = trial.summary
    return film_of(scenario, trial.film, ego=_ego_name(scenario), collided=summary.collided, text=summary.text)


def film_of_start(scenario: Scenario) -> dict[str, Any]:
    """The scenario as it is built: everybody where it begins.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    film = Film()
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        if simulation.seen is not None:
            film.ego.append(tick.scene.ego)
            film.objects.append(simulation.seen.around)
            film.names.append(simulation.seen.names)
    return film_of(scenario, film, ego=_ego_name(scenario), collided=False, text="as built, not driven")


def save_film(film: dict[str, Any], path: Path) -> None:
    """Write a film beside the picture of its episode.

    Raises:
        InputError: the file cannot be written.
    """
    write_text(path, json.dumps(film, separators=(",", ":"), allow_nan=False) + "\n")


def film_beside(picture: Path) -> Path:
    """Where the film of an episode lies whose picture is a file."""
    return picture.with_name(picture.stem + ENDING)


def load_film(path: Path) -> dict[str, Any] | None:
    """A film; None where there is none that can be played."""
    try:
        film = read_json(path, TEXT)
    except InputError:
        return None
    return film if isinstance(film, dict) and film.get("format") == _FORMAT else None


def _ego_name(scenario: Scenario) -> str:
    origin = scenario.origin
    return f"v{origin.vehicle}" if origin is not None and hasattr(origin, "vehicle") else "ego"


def _pose(x: float, y: float, yaw: float) -> list[float]:
    return [round(float(x), 2), round(float(y), 2), round(float(yaw), 3)]


def _lanes(scenario: Scenario, way: list[tuple[float, float]]) -> list[dict[str, Any]]:
    middle = way[-1] if way else (0.0, 0.0)
    lanes = lanes_of(read_network(network_file(scenario.network)))
    drawn = []
    for kind, name in _KINDS.items():
        for line, width in zip(*lanes.lines(kind), strict=True):
            if min(math.dist(middle, point) for point in line) < _REACH:
                points = [[round(float(x), 2), round(float(y), 2)] for x, y in line]
                drawn.append({"kind": name, "width": round(float(width), 2), "points": points})
    return drawn
