"""What a built crash scenario looks like from above, and its run, as plain data that a page plays."""

import json
import math
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from roadmend.core.bounds import TEXT
from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json
from roadmend.core.tick import INTERVAL
from roadmend.core.whole_file import write_text
from roadmend.safe.film import Film
from roadmend.safe.trial import CrashTestEpisode, blank_film
from roadmend.world.network import network_file
from roadmend.world.road_network import LaneKind, lanes_of, read_network
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

ENDING = ".film.json"
_FORMAT: Literal["roadmend-crash-film/1"] = "roadmend-crash-film/1"
_EVERY = 2  # ticks a frame: 10 a second
_REACH = 400.0  # [m] from the vehicles, beyond which no lane is drawn
_KINDS = {LaneKind.WALK: "walk", LaneKind.ROAD: "road", LaneKind.JUNCTION: "junction"}


class _Part(BaseModel):
    """What is read from a file that may have been altered."""

    model_config = ConfigDict(allow_inf_nan=False)


class _Vehicle(_Part):
    name: str
    length: float
    width: float


class _DrawnLane(_Part):
    kind: str
    width: float
    points: list[tuple[float, float]]


class _Played(_Part):
    """What the page that plays a film asks of it."""

    format: Literal["roadmend-crash-film/1"]
    scenario: str
    text: str
    collided: bool
    vehicles: list[_Vehicle]
    frames: list[tuple[float, list[tuple[float, float, float] | None]]] = Field(min_length=1)
    lanes: list[_DrawnLane]


def film_of(scenario: Scenario, film: Film, *, collided: bool, text: str) -> dict[str, Any]:
    """A run as plain data: lanes, bodies and, ten times a second, where everybody is.

    Args:
        scenario: that was run.
        film: where everybody was; at least one tick.
        collided: whether it ended with a contact, so that the last frame is its moment.
        text: how it ended.
    """
    names = film.names
    last = len(film.ego) - 1
    ticks = [*range(0, last, _EVERY), last]
    frames, bodies = [], dict.fromkeys(names, (4.5, 1.8))
    for tick in ticks:
        places: list[list[float] | None] = [None] * len(names)
        for name, pose in film.poses(tick).items():
            places[names.index(name)] = _pose(pose.x, pose.y, pose.yaw)
            bodies[name] = pose.length, pose.width
        frames.append([round(tick * INTERVAL, 2), places])
    vehicles: list[dict[str, Any]] = [
        {"name": name, "length": round(bodies[name][0], 2), "width": round(bodies[name][1], 2)}
        | ({"fixed": True} if name in film.fixed else {})
        for name in names
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
    return film_of(scenario, trial.film, collided=summary.collided, text=summary.text)


def film_of_start(scenario: Scenario) -> dict[str, Any]:
    """The scenario as it is built: everybody where it begins.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    film = blank_film(scenario)
    with Simulation(scenario) as simulation:
        tick = simulation.first()
        if simulation.seen is not None:
            film.add(tick.scene.ego, simulation.seen.around, simulation.everyone())
    return film_of(scenario, film, collided=False, text="as built, not driven")


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
        played = _Played.model_validate(film)
    except (InputError, ValidationError):
        return None
    return film if all(len(places) == len(played.vehicles) for _, places in played.frames) else None


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
