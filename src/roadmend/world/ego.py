"""The ego's body: longitudinal dynamics driven by throttle and brake, lateral motion along its route."""

import math
from dataclasses import dataclass, replace

from roadmend.core.command import Command
from roadmend.core.geometry import wrap_angle
from roadmend.core.route import Route

GRAVITY = 9.81  # [m/s2]
STANDING = 0.05  # [m/s] below which the ego, or who it meets, stands


@dataclass(frozen=True, slots=True)
class VehicleParameters:
    """Longitudinal parameters of a mid-size car."""

    acceleration_max: float = 3.5  # [m/s2] tractive limit at low speed
    power_per_mass: float = 60.0  # [W/kg] engine limit at high speed
    brake_max: float = 8.0  # [m/s2] deceleration at full brake on a dry road
    drag: float = 0.00027  # [1/m] air drag per mass: 0.5 * 1.2 kg/m3 * 0.3 * 2.2 m2 / 1500 kg
    rolling: float = 0.12  # [m/s2] rolling resistance
    throttle_lag: float = 0.25  # [s] first-order lag of the engine
    brake_lag: float = 0.12  # [s] first-order lag of the brake


class LongitudinalDynamics:
    """Point mass with actuator lag, drag, an engine limit and a friction circle; never rolls backwards."""

    def __init__(self, parameters: VehicleParameters, friction: float, speed: float) -> None:
        self._parameters = parameters
        self._grip = friction * GRAVITY  # [m/s2] largest acceleration that the tyres transmit
        self._throttle = 0.0
        self._brake = 0.0
        self.speed = speed  # [m/s]
        self.acceleration = 0.0  # [m/s2] over the last step

    def scale(self, engine: float, brake: float) -> None:
        """From now on the engine and the brake are stronger or weaker by these factors."""
        p = self._parameters
        self._parameters = replace(
            p,
            acceleration_max=p.acceleration_max * engine,
            power_per_mass=p.power_per_mass * engine,
            brake_max=p.brake_max * brake,
        )

    def step(self, command: Command, interval: float, curvature: float) -> float:
        """Advance by ``interval`` [s] on a path of ``curvature`` [1/m]; returns the distance driven [m]."""
        p = self._parameters
        self._throttle += (command.throttle - self._throttle) * (1.0 - math.exp(-interval / p.throttle_lag))
        self._brake += (command.brake - self._brake) * (1.0 - math.exp(-interval / p.brake_lag))
        lateral = self.speed * self.speed * curvature
        grip = math.sqrt(max(self._grip * self._grip - lateral * lateral, 0.04 * self._grip * self._grip))
        drive = min(p.acceleration_max, p.power_per_mass / max(self.speed, 1.0)) * self._throttle
        tyres = min(max(drive - p.brake_max * self._brake, -grip), grip)
        resistance = p.drag * self.speed * self.speed + (p.rolling if self.speed > 0.0 or drive > p.rolling else 0.0)
        before = self.speed
        self.speed = max(0.0, before + (tyres - resistance) * interval)
        self.acceleration = (self.speed - before) / interval
        return 0.5 * (before + self.speed) * interval


class RouteFollower:
    """Moves a point along the route: along a stage, and across to the next one during a lane change."""

    CHANGE_TIME = 3.0  # [s] that a lane change takes
    CHANGE_LENGTH_MIN = 12.0  # [m]

    def __init__(self, route: Route, position: float) -> None:
        self.route = route
        self.stage = 0
        self.position = position  # [m] arc length on the current stage
        self._next_position = 0.0  # [m] arc length on the next stage during a change
        self._progress = -1.0  # share of the change that is done, negative outside a change
        self._change_length = 0.0  # [m]
        self.x, self.y, self.yaw = route.stages[0].pose(position)
        self.curvature = 0.0  # [1/m]

    @property
    def changing(self) -> bool:
        """Whether a lane change is under way."""
        return self._progress >= 0.0

    @property
    def at_goal(self) -> bool:
        """Whether the task is complete."""
        return self.stage == len(self.route.stages) - 1 and not self.changing and self.position >= self.route.goal

    @property
    def off_route(self) -> bool:
        """Whether the lane has ended under the ego before the route did."""
        return not self.changing and self.position > self.route.stages[self.stage].length + 0.5

    def begin_change(self, speed: float) -> bool:
        """Begin the next lane change if the window is open; returns whether it began."""
        if self.changing or self.stage >= len(self.route.windows):
            return False
        window = self.route.windows[self.stage]
        if not window.begin <= self.position <= window.end:
            return False
        after = self.route.stages[self.stage + 1]
        self._next_position, _ = after.project(self.x, self.y, 0.5 * after.length, after.length)
        self._progress = 0.0
        self._change_length = max(self.CHANGE_LENGTH_MIN, self.CHANGE_TIME * speed)
        return True

    def advance(self, distance: float) -> None:
        """Drive ``distance`` [m] further."""
        self.position += distance
        x, y, yaw = self.route.stages[self.stage].pose(self.position)
        if self.changing:
            self._next_position += distance
            self._progress = min(1.0, self._progress + distance / self._change_length)
            x, y, yaw = self._blend(x, y, yaw)
            if self._progress >= 1.0:
                self.stage += 1
                self.position = self._next_position
                self._progress = -1.0
        if distance > 1e-6:
            turn = wrap_angle(yaw - self.yaw)
            self.curvature += 0.3 * (abs(turn) / distance - self.curvature)
        self.x, self.y, self.yaw = x, y, wrap_angle(yaw)

    def _blend(self, x: float, y: float, yaw: float) -> tuple[float, float, float]:
        """Quintic blend between the two lanes: no step in offset, slope or curvature at either end."""
        to_x, to_y, to_yaw = self.route.stages[self.stage + 1].pose(self._next_position)
        u = self._progress
        weight = u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
        slope = 30.0 * u * u * (1.0 - u) * (1.0 - u) / self._change_length
        offset = math.hypot(to_x - x, to_y - y)
        side = 1.0 if math.cos(yaw) * (to_y - y) - math.sin(yaw) * (to_x - x) >= 0.0 else -1.0
        blended_yaw = yaw + weight * wrap_angle(to_yaw - yaw) + side * math.atan(slope * offset)
        return x + weight * (to_x - x), y + weight * (to_y - y), blended_yaw
