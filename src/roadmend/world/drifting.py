"""Manoeuvres off the lanes, where SUMO's own lane changes cannot take a vehicle: leaving a lane, following a line."""

import math

import libsumo

from roadmend.world.scenario_actors import Drift, Follow
from roadmend.world.steering import SteeredVehicle, line_through

_QUINTIC = 10.0 / math.sqrt(3.0)  # largest second derivative of the quintic below
_COMFORT = 3.4  # [m/s2] across the way that a drift asks for at most; the rest is for bends and for steering back


class Drifter:
    """Leads one vehicle along its lane and away from it, at constant speed, as fast sideways as tyres can."""

    def __init__(
        self, vehicle: str, drift: Drift, time: float, grip: float, before: "Drifter | Follower | None" = None
    ) -> None:
        """Begin at ``time`` [s] with the pose and speed that the vehicle has, on a road that transmits ``grip``.

        ``before`` is what led it until now, if anything did.
        """
        self.driven: SteeredVehicle = SteeredVehicle(vehicle, None, grip, None if before is None else before.driven)
        self._drift, self._time = drift, time
        self._beside = self.driven.beside
        self._speed = self.driven.body.speed
        # At low speed the way sideways is as long as the body's heading allows: about as far ahead as aside.
        slow = 2.0 * abs(drift.offset) / max(self._speed, 0.5)
        self._over = max(drift.over, math.sqrt(_QUINTIC * abs(drift.offset) / min(_COMFORT, 0.5 * grip)), slow)

    def step(self, time: float) -> bool:
        """Drive the vehicle to where it is at ``time`` [s]; returns whether it still is on the road."""
        driven = self.driven
        if driven.vehicle not in libsumo.vehicle.getIDList():
            return False
        if driven.at_end:
            libsumo.vehicle.remove(driven.vehicle)
            return False
        driven.step(self._speed, lambda later: self._offset(time + later))
        return True

    def _offset(self, time: float) -> float:
        """Metres to the left of the lane at a time; quintic: no step in place, direction or curvature."""
        share = min(max((time - self._time) / self._over, 0.0), 1.0)
        return float(self._beside + self._drift.offset * share**3 * (10.0 + share * (-15.0 + 6.0 * share)))


class Follower:
    """Leads one vehicle along a line of its own, forwards or backwards, and has it stand at the end."""

    def __init__(self, vehicle: str, follow: Follow, grip: float, before: "Drifter | Follower | None" = None) -> None:
        """Begin with the pose and speed that the vehicle has, on a road that transmits ``grip`` [m/s2]."""
        self.driven: SteeredVehicle = SteeredVehicle(
            vehicle, line_through(follow.points), grip, None if before is None else before.driven
        )
        self._follow = follow

    def step(self, _time: float) -> bool:
        """Drive on for a tick; returns whether the vehicle is still there."""
        driven, follow = self.driven, self._follow
        if driven.vehicle not in libsumo.vehicle.getIDList():
            return False
        left = max(driven.line.length - driven.position - 0.5, 0.0)
        stopping = math.sqrt(2.0 * 3.0 * left)  # [m/s] from which 3 m/s2 bring it to the end
        driven.step(min(follow.speed, stopping), lambda _later: 0.0, backwards=follow.backwards)
        return True
