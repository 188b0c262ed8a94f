"""Descriptors drawn from the families' parameter spaces by the hundred thousand, without building a scenario.

For measuring a bank, not for learning: what comes out can be found, but not run. Where a family moves a vehicle that
has no room, or leaves it out, nothing is moved here, so the figures of a point differ a little from its scenario's.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from roadmend.sera.describe import hazard_kind, side_on_road
from roadmend.sera.descriptor import (
    PARTICIPANTS,
    BankEntry,
    Control,
    Descriptor,
    EgoManoeuvre,
    Hazard,
    Light,
    OutcomeName,
    OutcomeStatistics,
    ParticipantKind,
    RoadDescriptor,
    RoadKind,
    Side,
)
from roadmend.world.families import FAMILIES, highway, intersection
from roadmend.world.families.traffic import count_of
from roadmend.world.scenario import Environment, Weather
from roadmend.world.scenario_actors import DriverName
from roadmend.world.space import Choice, Dimension, Uniform, Whole

_BATCH = 500
_POLICY = "generated"
_SHARE_RUN = 0.5  # of the scenarios have outcome statistics
_MANOEUVRES: dict[str, EgoManoeuvre] = {
    "S1": "left_turn",
    "S2": "right_turn",
    "S3": "straight",
    "S4": "exit",
    "S5": "merge",
}
_TARGETS: dict[str, str] = {"S1": "west", "S2": "east", "S3": "north"}
_SIDES: dict[str, Side] = {"east": "right", "north": "oncoming", "west": "left"}
_ACTIONS = {"none": [], "brake": ["brake"], "cut_in": ["cut_in"], "swoop": ["cut_in", "brake"], "run": ["run"]}
Row = Mapping[str, Any]  # values by dimension; those of slots are arrays over the slots


def generate(count: int, seed: int) -> Iterator[BankEntry]:
    """Descriptions of ``count`` scenarios, the families taking turns; the same seed gives the same ones."""
    generator = np.random.default_rng(seed)
    names = tuple(_MANOEUVRES)
    done = 0
    while done < count:
        name = names[done // _BATCH % len(names)]
        batch = min(_BATCH, count - done)
        columns = _draw(name, batch, generator)
        outcomes = _draw_outcomes(batch, generator)
        for place in range(batch):
            row = {key: values[place] for key, values in columns.items()}
            build = _highway if name in ("S4", "S5") else _intersection
            digest = hashlib.sha256(f"generated/{seed}/{done + place}".encode()).hexdigest()
            yield BankEntry(digest, f"generated-{seed}-{done + place}", "generated", build(name, row, outcomes[place]))
        done += batch


def _draw(name: str, count: int, generator: np.random.Generator) -> dict[str, Any]:
    """Values of every dimension: shape (count,), and (count, slots) for those of slots, as ``v.kind`` or ``p.kind``."""
    space = FAMILIES[name].space
    slots: dict[str, int] = {}
    for key in space:
        head, dot, tail = key.partition(".")
        if dot:
            slots[f"{head[0]}.{tail}"] = slots.get(f"{head[0]}.{tail}", 0) + 1
    columns: dict[str, Any] = {
        key: _draw_dimension(dimension, (count,), generator) for key, dimension in space.items() if "." not in key
    }
    for key, number in slots.items():
        kind, _, tail = key.partition(".")
        columns[key] = _draw_dimension(space[f"{kind}0.{tail}"], (count, number), generator)
    return columns


def _draw_dimension(dimension: Dimension, shape: tuple[int, ...], generator: np.random.Generator) -> list[Any]:
    values: NDArray[Any]
    match dimension:
        case Uniform(low, high):
            values = generator.uniform(low, high, shape)
        case Whole(low, high):
            values = generator.integers(low, high, shape, endpoint=True)
        case Choice(weights):
            options, shares = np.array([*weights], dtype=object), np.array([*weights.values()])
            values = options[generator.choice(len(options), shape, p=shares / shares.sum())]
        case _:
            raise TypeError(f"a dimension of the unknown kind {type(dimension).__name__}")
    drawn: list[Any] = values.tolist()
    return drawn


def _draw_outcomes(count: int, generator: np.random.Generator) -> list[tuple[OutcomeStatistics, ...]]:
    """Statistics of one policy: half never run, the others up to four times, one in five of them a failure at least."""
    runs = generator.integers(1, 4, count, endpoint=True)
    failures = generator.binomial(runs, 0.1)
    distances = generator.uniform(0.0, 12.0, count).round(2)
    is_run = generator.uniform(size=count) < _SHARE_RUN
    result: list[tuple[OutcomeStatistics, ...]] = []
    for known, run, failed, distance in zip(
        is_run.tolist(), runs.tolist(), failures.tolist(), distances.tolist(), strict=True
    ):
        counts: dict[OutcomeName, int] = {}
        if failed:
            counts["COLLISION"] = failed
        if run > failed:
            counts["GOAL"] = run - failed
        result.append((OutcomeStatistics(_POLICY, counts, 0.0 if failed else distance),) if known else ())
    return result


def _intersection(name: str, row: Row, outcomes: tuple[OutcomeStatistics, ...]) -> Descriptor:
    arms = ["south", "east", "north", "west"]
    if row["layout"] == "tee":
        spare = [arm for arm in ("east", "north", "west") if arm != _TARGETS[name]]
        arms = ["south", _TARGETS[name], spare[row["third_arm"]]]
    participants, drivers = Counter[ParticipantKind](), Counter[DriverName]()
    hazards: list[Hazard] = []
    for slot in range(count_of(intersection.VEHICLE_COUNTS, row)):
        arm = row["v.from"][slot]
        if arm not in arms:
            arm = arms[1 + slot % (len(arms) - 1)]
        arrival = row["v.arrival"][slot] * row["v.speed"][slot] * row["speed_limit"]
        is_ahead = arrival < row["ego_distance"]
        side = _SIDES.get(arm) or side_on_road(0, 0, is_ahead=is_ahead)
        hazards += _vehicle_hazard(row, slot, side)
        participants[row["v.kind"][slot]] += 1
        drivers[row["v.driver"][slot]] += 1
    if row["crossings"]:
        for slot in range(count_of(intersection.PEDESTRIAN_COUNTS, row)):
            arm = row["p.from"][slot] if row["p.from"][slot] in arms else arms[0]
            is_ahead = row["p.arrival"][slot] * row["p.speed"][slot] < row["ego_distance"]
            side = _SIDES.get(arm) or side_on_road(0, 0, is_ahead=is_ahead)
            hazards.append(Hazard("pedestrian_crossing", "pedestrian", side))
            participants["pedestrian"] += 1
            drivers[row["p.driver"][slot]] += 1
    control: Control = "priority" if row["control"] in ("minor", "major") else row["control"]
    kind: RoadKind = "tee_junction" if row["layout"] == "tee" else "intersection"
    road = RoadDescriptor(kind, row["lanes"], row["speed_limit"], control, row["crossings"])
    return _descriptor(name, row, road, participants, drivers, hazards, row["speed_limit"], outcomes)


def _highway(name: str, row: Row, outcomes: tuple[OutcomeStatistics, ...]) -> Descriptor:
    lanes = row["lanes"]
    ego_lane = min(int(row["ego_lane"] * lanes), lanes - 1, 1)
    participants, drivers = Counter[ParticipantKind](), Counter[DriverName]()
    hazards: list[Hazard] = []
    for slot in range(count_of(highway.VEHICLE_COUNTS, row)):
        is_ahead = row["v.offset"][slot] > 0.0
        if name == "S4":
            lane = min(int(row["v.lane"][slot] * lanes), lanes - 1)
            side = side_on_road(ego_lane, lane, is_ahead=is_ahead)
        else:
            side = side_on_road(0, 0, is_ahead=is_ahead) if row["v.side"][slot] < 0.12 else "left"
        hazards += _vehicle_hazard(row, slot, side)
        participants[row["v.kind"][slot]] += 1
        drivers[row["v.driver"][slot]] += 1
    road = RoadDescriptor("highway_exit" if name == "S4" else "on_ramp", lanes, row["speed_limit"])
    limit = row["speed_limit"] if name == "S4" else row["ramp_speed_limit"]
    return _descriptor(name, row, road, participants, drivers, hazards, limit, outcomes)


def _vehicle_hazard(row: Row, slot: int, side: Side) -> list[Hazard]:
    kind = hazard_kind(_ACTIONS[row["v.manoeuvre"][slot]])
    if kind is None:
        return []
    distance = round(row["v.near"][slot], 3) if row["v.cue"][slot] == "ego" else None
    return [Hazard(kind, row["v.kind"][slot], side, distance)]


def _descriptor(
    name: str,
    row: Row,
    road: RoadDescriptor,
    participants: Counter[ParticipantKind],
    drivers: Counter[DriverName],
    hazards: list[Hazard],
    limit: float,
    outcomes: tuple[OutcomeStatistics, ...],
) -> Descriptor:
    around = _ENVIRONMENTS[row["weather"], row["time_of_day"]]
    return Descriptor(
        road=road,
        manoeuvre=_MANOEUVRES[name],
        participants={kind: participants[kind] for kind in PARTICIPANTS if participants[kind]},
        drivers=dict(sorted(drivers.items())),
        hazards=tuple(hazards),
        weather=around.weather,
        light=around.time_of_day,
        friction=around.effective_friction,
        sensing_range=around.effective_range,
        ego_speed=round(row["ego_speed"] * limit, 2),
        family=name,
        outcomes=outcomes,
    )


_ENVIRONMENTS = {
    (weather, light): Environment(weather=weather, time_of_day=light)
    for weather in get_args(Weather)
    for light in get_args(Light)
}
