"""PredictiveBrake: roll every object and the planned trajectory forward, brake where outlines will meet."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.geometry import corner_distance, fill_outline
from roadmend.core.jit import compiled, unnamed
from roadmend.core.repair import Proposal, RepairTrigger
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.repair.contact import Forecast, first_contact, is_follower, merit, roll_object
from roadmend.repair.latch import Latch
from roadmend.repair.parameters import PredictiveParameters
from roadmend.repair.planned_path import PathFinder, PlannedPath, planned_position

Floats = NDArray[np.float64]

CLEAR, AVOIDED, MITIGATED, IN_VAIN = 0, 1, 2, 3


class PredictionSettings(NamedTuple):
    """How to predict; see PredictiveParameters."""

    margin: float  # [m]
    steps: int
    interval: float  # [s]
    turning: bool
    slowing: bool
    adaptive: bool
    full_brake: float  # [m/s2]


@compiled
def _margins(path: PlannedPath, ego: EgoState, objects: Objects, reach: float, margin: float, horizon: float) -> Floats:
    """Gap [m] that each of N objects must keep, shape (N,); negative for those that play no part.

    Never more than half the gap there is now: something that stands close beside the ego blocks it only if the two
    would come closer still, so a stopped ego can always leave what is not in its path.
    """
    required = np.full(objects.shape[0], -1.0)
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    own_radius = 0.5 * math.hypot(ego.length, ego.width)
    fill_outline(own, ego)
    for index in range(objects.shape[0]):
        other = objects[index]
        gap = math.hypot(other.x - ego.x, other.y - ego.y)
        gap -= own_radius + 0.5 * math.hypot(other.length, other.width)
        if gap > reach + abs(other.speed) * horizon + margin or is_follower(path, ego, other):
            continue
        required[index] = margin
        if gap < 2.0 * margin:
            fill_outline(their, other)
            required[index] = min(margin, 0.5 * corner_distance(own, their))
    return required


@compiled
def predict(
    path: PlannedPath, ego: EgoState, objects: Objects, manner: PredictionSettings
) -> tuple[int, int, int, int]:
    """Outcome (CLEAR .. IN_VAIN), step and object of the planned contact, and braking in fifths of the full brake."""
    path, ego, manner = PlannedPath(*path), EgoState(*ego), PredictionSettings(*manner)
    steps, interval = manner.steps, manner.interval
    horizon = steps * interval
    reach = max(planned_position(path, horizon), 0.0)
    required = _margins(path, ego, objects, reach, manner.margin, horizon)
    poses = np.empty((objects.shape[0], 2 * steps + 1, 4), dtype=np.float64)
    for index in range(objects.shape[0]):
        if required[index] >= 0.0:
            other = objects[index]
            poses[index, 0, 0], poses[index, 0, 1] = other.x, other.y
            poses[index, 0, 2], poses[index, 0, 3] = other.yaw, other.speed
            slow = min(0.0, other.acceleration) if manner.slowing else 0.0
            roll_object(poses[index], 0, steps, other.yaw_rate if manner.turning else 0.0, slow, interval)
    forecast = Forecast(objects, poses, required, interval)
    contact, focus = first_contact(path, ego, -1.0, forecast, 0, steps, -1)
    if contact < 0:
        return CLEAR, -1, -1, 0
    if not manner.adaptive:
        return AVOIDED, contact, focus, 5

    slow = min(0.0, objects[focus].acceleration) if manner.slowing else 0.0
    turning = objects[focus].yaw_rate if manner.turning else 0.0
    roll_object(poses[focus], steps, 2 * steps, turning, slow, interval)
    for fifths in range(6):
        deceleration = 0.2 * fifths * manner.full_brake
        step, _ = first_contact(path, ego, deceleration, forecast, 0, steps, -1)
        if step < 0:
            step, _ = first_contact(path, ego, deceleration, forecast, steps + 1, 2 * steps, focus)
        if step < 0:
            return AVOIDED, contact, focus, fifths

    best, chosen = -math.inf, -1
    for fifths in range(-1, 6):
        value = merit(path, ego, 0.2 * fifths * manner.full_brake, forecast, steps)
        if value > best or (value == best and fifths > 0):  # of equals the strongest, but nothing before rolling on
            best, chosen = value, fifths
    if chosen < 0:
        return IN_VAIN, contact, focus, 0
    return MITIGATED, contact, focus, chosen


class PredictiveRepair:
    """Brakes where the planned motion would bring the ego's outline into contact with a predicted one.

    Score: 1 - t / (H + dt), t the time to the first contact within the horizon H and dt the step, 0 where there is
    none; threshold: 0. During an intervention H and the margin are larger by the share ``release``. The trigger is the object of the first contact, its weight the score.

    With ``adaptive`` the proposal is the mildest braking that keeps clear of all objects over H and of the triggering
    one over 2 H; where none does, the one that keeps the largest gap or hits slowest, and no braking where going on
    is better, as in the middle of a conflict zone. Otherwise it is always the full brake.
    """

    name = "predictive"

    def __init__(self, parameters: PredictiveParameters | None = None) -> None:
        self._parameters = parameters or PredictiveParameters()
        self._steps = max(1, round(self._parameters.horizon / self._parameters.interval))
        self._manner = PredictionSettings(
            self._parameters.margin,
            self._steps,
            self._parameters.interval,
            self._parameters.turning,
            self._parameters.slowing,
            self._parameters.adaptive,
            self._parameters.full_brake,
        )
        more = 1.0 + self._parameters.release
        self._held_manner = self._manner._replace(
            margin=self._parameters.margin * more, steps=math.ceil(self._steps * more)
        )
        self._finder = PathFinder()
        self._latch = Latch(self._parameters.hold, self._parameters.clear)
        self._idle = Proposal(0.0, 0.0, 0.8)

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._finder.reset(route)
        self._latch.reset()

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick."""
        proposal = self._predict(scene, decision) if len(scene.objects) else self._idle
        return self._latch.settle(scene.time, proposal)

    def _predict(self, scene: Scene, decision: Decision) -> Proposal:
        ego, objects, parameters = scene.ego, scene.objects, self._parameters
        manner = self._held_manner if self._latch.is_on else self._manner
        speed = max(0.0, ego.speed)
        path = self._finder.find(ego, decision.trajectory, 20.0 + (speed + 2.0) * manner.steps * manner.interval)
        outcome, step, index, fifths = predict(unnamed(path), unnamed(ego), objects.table, unnamed(manner))
        if outcome == CLEAR:
            return self._idle
        number, time = int(objects.id[index]), step * parameters.interval
        score = 1.0 - step / (manner.steps + 1.0)
        reason = f"object {number} within {manner.margin:.2f} m in {time:.1f} s"
        action = round(-0.2 * fifths, 1) if fifths else 0.0
        if outcome == IN_VAIN:
            action = decision.command.action
            reason += ", no braking avoids it: going on"
        elif outcome == MITIGATED:
            reason += ", no braking keeps clear"
        return Proposal(score, 0.0, action, (RepairTrigger(number, score),), reason)
