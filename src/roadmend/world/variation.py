"""How the world may differ from here on: what nobody can know of the others, and how exactly a vehicle obeys."""

import random
from dataclasses import dataclass, fields

import libsumo

from roadmend.world.drivers import entry_speed
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Vehicle
from roadmend.world.traffic_file import EGO

_ASSERTIVENESS = "laneChangeModel.lcAssertive"
_NOT_BEFORE = 0.1  # [s] from now that somebody who is still to come departs at the earliest


@dataclass(frozen=True, slots=True)
class Spread:
    """How far futures of one moment lie apart. Shares are of a driver's own value, standard deviations where not said."""

    desired_speed: float = 0.05  # share
    imperfection: float = 0.1  # of SUMO's sigma, 0 .. 1
    headway: float = 0.1  # share, of SUMO's tau
    impatience: float = 0.15  # of SUMO's, 0 .. 1, by which smaller gaps are taken at junctions
    assertiveness: float = 0.15  # share, of the will to change lanes into smaller gaps
    departure: float = 0.5  # [s] of those who are still to come
    actuation: float = 0.02  # share by which the ego's engine and brake are stronger or weaker
    limit: float = 2.0  # standard deviations at most


def vary_traffic(scenario: Scenario, time: float, numbers: random.Random, spread: Spread) -> None:
    """Change everybody in SUMO but the ego.

    Those too who are still to depart, as far as SUMO has read of them (some ten seconds ahead) and where the scenario
    names them: the traffic of a user's own configuration departs when it would.

    Args:
        scenario: that is running.
        time: [s] now.
        numbers: where chance comes from.
        spread: how much.
    """
    present = sorted(set(libsumo.vehicle.getIDList()) - {EGO})
    coming = [
        actor
        for actor in scenario.actors
        if isinstance(actor, Vehicle) and actor.depart > time and actor.id not in present and _is_loaded(actor.id)
    ]
    departures = [actor.depart + deviation(numbers, spread.departure, spread) for actor in coming]
    habits = {name: _Habits.drawn(numbers, spread) for name in [*present, *(actor.id for actor in coming)]}
    for actor, depart in zip(coming, departures, strict=True):
        _postpone(actor, max(time + _NOT_BEFORE, depart), 1.0 + habits[actor.id].desired_speed)
    for name, varied in habits.items():
        _vary_driver(name, varied)
    for name in sorted(libsumo.person.getIDList()):
        factor = libsumo.person.getSpeedFactor(name)
        libsumo.person.setSpeedFactor(name, factor * (1.0 + deviation(numbers, spread.desired_speed, spread)))


def deviation(numbers: random.Random, size: float, spread: Spread) -> float:
    """A normal number of the standard deviation ``size``, within the spread's limit."""
    drawn = numbers.gauss(0.0, 1.0)
    return size * max(-spread.limit, min(spread.limit, drawn))


@dataclass(frozen=True, slots=True)
class _Habits:
    """By how much one driver differs."""

    desired_speed: float
    imperfection: float
    headway: float
    impatience: float
    assertiveness: float

    @classmethod
    def drawn(cls, numbers: random.Random, spread: Spread) -> "_Habits":
        return cls(*(deviation(numbers, getattr(spread, each.name), spread) for each in fields(cls)))


def _vary_driver(name: str, varied: _Habits) -> None:
    vehicle = libsumo.vehicle
    factor = vehicle.getSpeedFactor(name)
    vehicle.setImperfection(name, min(1.0, max(0.0, vehicle.getImperfection(name) + varied.imperfection)))
    vehicle.setTau(name, vehicle.getTau(name) * (1.0 + varied.headway))
    vehicle.setImpatience(name, min(1.0, max(0.0, vehicle.getImpatience(name) + varied.impatience)))
    assertive = vehicle.getParameter(name, _ASSERTIVENESS)
    if assertive:
        vehicle.setParameter(name, _ASSERTIVENESS, f"{float(assertive) * (1.0 + varied.assertiveness):.6g}")
    vehicle.setSpeedFactor(name, factor * (1.0 + varied.desired_speed))  # last: the others put the type's own back


def _postpone(actor: Vehicle, depart: float, hurry: float) -> None:
    """Let somebody who is still to come do so at another time [s].

    At the scenario's speed, as far as a driver goes so fast who is about to want ``hurry`` times as much.
    """
    vehicle = libsumo.vehicle
    kind, factor = vehicle.getTypeID(actor.id), vehicle.getSpeedFactor(actor.id)
    route, lane = f"{actor.id}_at_another_time", _lane_number(actor)
    limit = libsumo.lane.getMaxSpeed(f"{actor.route[0]}_{lane}")
    libsumo.route.add(route, list(actor.route))
    vehicle.remove(actor.id)  # takes its own route with it
    vehicle.add(
        actor.id,
        route,
        typeID=kind,
        depart=f"{depart:.2f}",
        departLane=str(lane),
        departPos=f"{actor.position:.2f}",
        departSpeed=entry_speed(actor, factor * min(1.0, hurry), limit),  # looked at here, and again on entry
    )
    vehicle.setSpeedFactor(actor.id, factor)


def _is_loaded(name: str) -> bool:
    try:
        libsumo.vehicle.getTypeID(name)
    except libsumo.TraCIException:
        return False
    return True


def _lane_number(actor: Vehicle) -> int:
    """SUMO's number of the lane that the scenario names, which counts lanes for cars only."""
    edge = actor.route[0]
    lanes = range(libsumo.edge.getLaneNumber(edge))
    for_cars = [lane for lane in lanes if _allows_cars(f"{edge}_{lane}")]
    return for_cars[actor.lane]


def _allows_cars(lane: str) -> bool:
    allowed = libsumo.lane.getAllowed(lane)
    return not allowed or "passenger" in allowed
