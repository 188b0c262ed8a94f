"""Vehicles that leave the lanes: steered along a line of their own, with the forces that tyres and steering have.

The body is a kinematic bicycle (Rajamani, Vehicle Dynamics and Control, 2.2): it goes where its wheels point. The line
is followed by pure pursuit (Coulter 1992). SUMO is told each tick where the body is, as it is for the ego.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import libsumo

from roadmend.core.geometry import wrap_angle
from roadmend.core.route import Stage
from roadmend.core.tick import INTERVAL
from roadmend.world.participants import Pose

_FREE_PLACE = 2  # moveToXY: exactly there, on or off the lane
_LATERAL = 0.42 * 9.81  # [m/s2] that a driver goes up to
_GRIP_SHARE = 0.8  # of what the road transmits that is used sideways at most
_SPEEDING_UP, _SLOWING_DOWN = 2.5, 6.0  # [m/s2]
_TIGHTEST = 1.0 / 5.0  # [1/m] curvature at full lock
_LOCK_TIME = 1.2  # [s] from straight ahead to full lock
_PREVIEW, _PREVIEW_LEAST = 0.7, 3.0  # [s], [m] that pure pursuit looks ahead


@dataclass(slots=True)
class SteeredBody:
    """A body's place and motion; its reference point is its middle.

    Attributes:
        x: [m] in the map frame.
        y: [m].
        yaw: [rad].
        speed: along its axis [m/s], negative backwards.
        lateral: largest acceleration across its way [m/s2].
        curvature: of its way [1/m], left is positive.
    """

    x: float
    y: float
    yaw: float
    speed: float
    lateral: float
    curvature: float = 0.0

    def step(self, wanted_speed: float, wanted_curvature: float) -> None:
        """Move for one tick towards a speed [m/s] and a curvature [1/m], as far as engine, brakes and tyres allow."""
        low, high = -_SLOWING_DOWN, _SPEEDING_UP
        if self.speed < 0.0 or (self.speed == 0.0 and wanted_speed < 0.0):
            low, high = -_SPEEDING_UP, _SLOWING_DOWN
        change = (wanted_speed - self.speed) / INTERVAL
        before = self.speed
        self.speed += min(max(change, low), high) * INTERVAL
        limit = min(_TIGHTEST, self.lateral / max(self.speed * self.speed, 1.0))
        rate = _TIGHTEST / _LOCK_TIME * INTERVAL
        turned = min(max(wanted_curvature - self.curvature, -rate), rate)
        self.curvature = min(max(self.curvature + turned, -limit), limit)
        distance = 0.5 * (before + self.speed) * INTERVAL
        middle = self.yaw + 0.5 * distance * self.curvature
        self.x += distance * math.cos(middle)
        self.y += distance * math.sin(middle)
        self.yaw = wrap_angle(self.yaw + distance * self.curvature)


class SteeredVehicle:
    """Drives one of SUMO's vehicles along a line, beside it by an offset that may change with time."""

    def __init__(self, vehicle: str, line: Stage | None, grip: float, before: "SteeredVehicle | None" = None) -> None:
        """Begin with the pose and speed that the vehicle has.

        Args:
            vehicle: SUMO's name of it.
            line: to follow; None for the line that it followed before, or else the centre line of its lane.
            grip: acceleration that the road transmits [m/s2].
            before: what steered it until now, if anything did.
        """
        self.vehicle = vehicle
        self._half = 0.5 * libsumo.vehicle.getLength(vehicle)
        self._width: float = libsumo.vehicle.getWidth(vehicle)
        self.body: SteeredBody = before.body if before is not None else _body_of(vehicle, self._half, grip)
        if line is None:
            line = before.line if before is not None else lane_line(vehicle)
        self.line: Stage = line
        self.position, self.beside = self.line.project(
            self.body.x, self.body.y, 0.5 * self.line.length, self.line.length
        )
        self.is_wrecked: bool = before is not None and before.is_wrecked  # it stands where it is for good
        libsumo.vehicle.setSpeedMode(vehicle, 0)
        libsumo.vehicle.setLaneChangeMode(vehicle, 0)

    @property
    def pose(self) -> Pose:
        """Where its body is, in the map frame."""
        body = self.body
        return Pose(body.x, body.y, body.yaw, body.speed, 2.0 * self._half, self._width)

    @property
    def at_end(self) -> bool:
        """Whether the middle has come to the end of the line."""
        return self.position >= self.line.length - 0.5

    def step(self, speed: float, offset: Callable[[float], float], *, backwards: bool = False) -> None:
        """Drive for one tick; ``offset`` gives metres to the left of the line for seconds from now."""
        if self.is_wrecked:
            self.body.speed = 0.0
            self._place()
            return
        body, line = self.body, self.line
        self.position, _ = line.project(body.x, body.y, self.position, 8.0)
        ahead = max(_PREVIEW_LEAST, _PREVIEW * abs(body.speed))
        beyond = self.position + ahead - line.length
        x, y, heading = line.pose(min(self.position + ahead, line.length))
        if beyond > 0.0:  # straight on past its end
            x, y = x + beyond * math.cos(heading), y + beyond * math.sin(heading)
        shift = offset(ahead / max(abs(body.speed), 1.0))
        x, y = x - shift * math.sin(heading), y + shift * math.cos(heading)
        yaw = body.yaw + (math.pi if backwards else 0.0)
        across = math.cos(yaw) * (y - body.y) - math.sin(yaw) * (x - body.x)
        apart = max((x - body.x) ** 2 + (y - body.y) ** 2, 1.0)
        curvature = 2.0 * across / apart
        # Curvature is measured along the axis: backwards, the same wheels turn the body the other way.
        body.step(-speed if backwards else speed, -curvature if backwards else curvature)
        self._place()

    def _place(self) -> None:
        """Tell SUMO where the body is."""
        body = self.body
        libsumo.vehicle.moveToXY(
            self.vehicle,
            "",
            -1,
            body.x + self._half * math.cos(body.yaw),
            body.y + self._half * math.sin(body.yaw),
            (90.0 - math.degrees(body.yaw)) % 360.0,
            _FREE_PLACE,
        )


def _body_of(vehicle: str, half: float, grip: float) -> SteeredBody:
    """The body of one of SUMO's vehicles, ``half`` a length [m] behind its front."""
    yaw = wrap_angle(math.radians(90.0 - libsumo.vehicle.getAngle(vehicle)))
    x, y = libsumo.vehicle.getPosition(vehicle)
    return SteeredBody(
        x - half * math.cos(yaw),
        y - half * math.sin(yaw),
        yaw,
        libsumo.vehicle.getSpeed(vehicle),
        min(_LATERAL, _GRIP_SHARE * grip),
    )


def lane_line(vehicle: str) -> Stage:
    """The centre line of the lane that a vehicle is on."""
    return line_through(libsumo.lane.getShape(libsumo.vehicle.getLaneID(vehicle)))


def line_through(points: Sequence[tuple[float, float]]) -> Stage:
    """A line through points [m]."""
    import numpy as np  # noqa: PLC0415 - only a manoeuvre off the lanes needs it

    shape = np.asarray(points, dtype=np.float64)
    return Stage(np.ascontiguousarray(shape[:, 0]), np.ascontiguousarray(shape[:, 1]), np.zeros(len(shape)))
