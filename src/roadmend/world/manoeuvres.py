"""Scripted misbehaviour of single actors, on top of what SUMO's drivers do by themselves."""

import math
from dataclasses import dataclass

import libsumo

from roadmend.world.scenario import Brake, CutIn, Manoeuvre, Scenario, Vehicle

_SPEED_MODE_NORMAL = 31
_SPEED_MODE_NO_RIGHT_OF_WAY = 31 - 8  # gives way to nobody who is not in the junction yet
_LANE_CHANGE_FORCED = 0  # SUMO obeys the request whatever is in the way
_LANE_CHANGE_NORMAL = 1621
_CUT_IN_TIME = 3.0  # [s] that a cut-in keeps its lane


@dataclass
class _Running:
    until: float  # [s]
    vehicle: str
    manoeuvre: Manoeuvre


class ManoeuvreScript:
    """Starts and ends the manoeuvres of a scenario's vehicles."""

    def __init__(self, scenario: Scenario) -> None:
        self._waiting: list[tuple[str, Manoeuvre]] = [
            (actor.id, manoeuvre)
            for actor in scenario.actors
            if isinstance(actor, Vehicle)
            for manoeuvre in actor.manoeuvres
        ]
        self._running: list[_Running] = []

    def step(self, time: float, ego_x: float, ego_y: float, present: frozenset[str] | set[str]) -> None:
        """Start what is due at ``time`` [s] with the ego at a point [m], end what is over."""
        if self._running:
            self._end(time, present)
        if not self._waiting:
            return
        still = []
        for vehicle, manoeuvre in self._waiting:
            if vehicle in present and self._due(time, ego_x, ego_y, vehicle, manoeuvre):
                self._running.append(_Running(time + _start(vehicle, manoeuvre), vehicle, manoeuvre))
            else:
                still.append((vehicle, manoeuvre))
        self._waiting = still

    @staticmethod
    def _due(time: float, ego_x: float, ego_y: float, vehicle: str, manoeuvre: Manoeuvre) -> bool:
        if manoeuvre.when.time is not None:
            return time >= manoeuvre.when.time
        x, y = libsumo.vehicle.getPosition(vehicle)
        return math.hypot(x - ego_x, y - ego_y) <= (manoeuvre.when.ego_distance or 0.0)

    def _end(self, time: float, present: frozenset[str] | set[str]) -> None:
        still = []
        for running in self._running:
            if running.vehicle not in present:
                continue
            if time < running.until:
                still.append(running)
                continue
            if isinstance(running.manoeuvre, Brake):
                libsumo.vehicle.setSpeed(running.vehicle, -1.0)
            elif isinstance(running.manoeuvre, CutIn):
                libsumo.vehicle.setLaneChangeMode(running.vehicle, _LANE_CHANGE_NORMAL)
            else:
                libsumo.vehicle.setSpeedMode(running.vehicle, _SPEED_MODE_NORMAL)
        self._running = still


def _start(vehicle: str, manoeuvre: Manoeuvre) -> float:
    """Begin a manoeuvre; returns how long it lasts [s]."""
    if isinstance(manoeuvre, Brake):
        speed = libsumo.vehicle.getSpeed(vehicle)
        duration = max(0.1, (speed - manoeuvre.speed) / manoeuvre.deceleration)
        libsumo.vehicle.slowDown(vehicle, min(speed, manoeuvre.speed), duration)
        return float(duration + manoeuvre.hold)
    if isinstance(manoeuvre, CutIn):
        lane = libsumo.vehicle.getLaneIndex(vehicle) + (1 if manoeuvre.direction == "left" else -1)
        edge = libsumo.vehicle.getRoadID(vehicle)
        if 0 <= lane < libsumo.edge.getLaneNumber(edge):
            libsumo.vehicle.setLaneChangeMode(vehicle, _LANE_CHANGE_FORCED)
            libsumo.vehicle.changeLane(vehicle, lane, _CUT_IN_TIME)
        return _CUT_IN_TIME
    libsumo.vehicle.setSpeedMode(vehicle, _SPEED_MODE_NO_RIGHT_OF_WAY)
    return manoeuvre.hold
