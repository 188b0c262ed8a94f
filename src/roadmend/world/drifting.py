"""Vehicles that leave their lane sideways, where SUMO's own lane changes cannot take them."""

import math

import libsumo
import numpy as np

from roadmend.core.route import Stage
from roadmend.world.scenario import Drift

_FREE_PLACE = 2  # moveToXY: exactly there, on or off the lane


class Drifter:
    """Leads one vehicle along its lane's centre line and away from it, at constant speed."""

    def __init__(self, vehicle: str, drift: Drift, time: float) -> None:
        """Begin at ``time`` [s] with the pose and speed that the vehicle has."""
        shape = np.asarray(libsumo.lane.getShape(libsumo.vehicle.getLaneID(vehicle)), dtype=np.float64)
        self._lane = Stage(np.ascontiguousarray(shape[:, 0]), np.ascontiguousarray(shape[:, 1]), np.zeros(len(shape)))
        self._vehicle, self._drift = vehicle, drift
        self._half = 0.5 * libsumo.vehicle.getLength(vehicle)
        self._speed = libsumo.vehicle.getSpeed(vehicle)
        heading = math.radians(90.0 - libsumo.vehicle.getAngle(vehicle))
        x, y = libsumo.vehicle.getPosition(vehicle)
        middle = x - self._half * math.cos(heading), y - self._half * math.sin(heading)
        self._begin, self._beside = self._lane.project(*middle, 0.5 * self._lane.length, self._lane.length)
        self._time = time
        libsumo.vehicle.setSpeedMode(vehicle, 0)
        libsumo.vehicle.setLaneChangeMode(vehicle, 0)

    def step(self, time: float) -> bool:
        """Put the vehicle where it is at ``time`` [s]; returns whether it still is on the road."""
        if self._vehicle not in libsumo.vehicle.getIDList():
            return False
        passed = time - self._time
        position = self._begin + self._speed * passed
        if position > self._lane.length + self._half:
            libsumo.vehicle.remove(self._vehicle)
            return False
        x, y, yaw = self._lane.pose(position)
        share = min(1.0, passed / self._drift.over)
        # Quintic: no step in place, direction or curvature at either end.
        offset = self._beside + self._drift.offset * share**3 * (10.0 + share * (-15.0 + 6.0 * share))
        slope = 30.0 * share**2 * (1.0 - share) ** 2 * self._drift.offset / self._drift.over / max(self._speed, 1.0)
        heading = yaw + math.atan(slope)
        x, y = x - offset * math.sin(yaw), y + offset * math.cos(yaw)
        libsumo.vehicle.moveToXY(
            self._vehicle,
            "",
            -1,
            x + self._half * math.cos(heading),
            y + self._half * math.sin(heading),
            (90.0 - math.degrees(heading)) % 360.0,
            _FREE_PLACE,
        )
        return True
