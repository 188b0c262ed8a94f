"""PredictiveBrake: roll every object and the planned trajectory forward, brake where outlines will meet."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.geometry import corner_distance, fill_corners
from roadmend.core.jit import compiled
from roadmend.core.repair import Proposal, Trigger
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.latch import Latch
from roadmend.repair.parameters import PredictiveParameters
from roadmend.repair.path import PathFinder, planned_position
from roadmend.repair.rollout import first_contact, is_follower, merit, roll_object

Floats = NDArray[np.float64]

CLEAR, AVOIDED, MITIGATED, IN_VAIN = 0, 1, 2, 3


class Manner(NamedTuple):
    """How to predict; see PredictiveParameters."""

    margin: float  # [m]
    steps: int
    interval: float  # [s]
    turning: bool
    slowing: bool
    adaptive: bool
    full_brake: float  # [m/s2]


@compiled
def _margins(
    points: Floats,
    count: int,
    reach: float,
    x: float,
    y: float,
    yaw: float,
    ego_length: float,
    ego_width: float,
    other_x: Floats,
    other_y: Floats,
    other_yaw: Floats,
    other_speed: Floats,
    length: Floats,
    width: Floats,
    margin: float,
    horizon: float,
) -> Floats:
    """Gap [m] that each of N objects must keep, shape (N,); negative for those that play no part.

    Never more than half the gap there is now: something that stands close beside the ego blocks it only if the two
    would come closer still, so a stopped ego can always leave what is not in its path.
    """
    required = np.full(other_x.shape[0], -1.0)
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    own_radius = 0.5 * math.hypot(ego_length, ego_width)
    fill_corners(own, x, y, yaw, ego_length, ego_width)
    for index in range(other_x.shape[0]):
        gap = math.hypot(other_x[index] - x, other_y[index] - y)
        gap -= own_radius + 0.5 * math.hypot(length[index], width[index])
        if gap > reach + abs(other_speed[index]) * horizon + margin:
            continue
        if is_follower(
            points,
            count,
            ego_length,
            ego_width,
            other_x[index],
            other_y[index],
            other_yaw[index],
            length[index],
            width[index],
        ):
            continue
        required[index] = margin
        if gap < 2.0 * margin:
            fill_corners(their, other_x[index], other_y[index], other_yaw[index], length[index], width[index])
            required[index] = min(margin, 0.5 * corner_distance(own, their))
    return required


@compiled
def predict(
    points: Floats,
    count: int,
    zero: int,
    progress: Floats,
    plan_interval: float,
    tail_speed: float,
    speed: float,
    ego_length: float,
    ego_width: float,
    x: Floats,
    y: Floats,
    yaw: Floats,
    other_speed: Floats,
    acceleration: Floats,
    yaw_rate: Floats,
    length: Floats,
    width: Floats,
    manner: Manner,
) -> tuple[int, int, int, int]:
    """Outcome (CLEAR .. IN_VAIN), step and object of the planned contact, and braking in fifths of the full brake."""
    steps, interval = manner.steps, manner.interval
    horizon = steps * interval
    reach = max(planned_position(progress, plan_interval, tail_speed, horizon), 0.0)
    required = _margins(
        points,
        count,
        reach,
        points[0, zero],
        points[1, zero],
        points[3, zero],
        ego_length,
        ego_width,
        x,
        y,
        yaw,
        other_speed,
        length,
        width,
        manner.margin,
        horizon,
    )
    poses = np.empty((x.shape[0], 2 * steps + 1, 4), dtype=np.float64)
    for index in range(x.shape[0]):
        if required[index] >= 0.0:
            poses[index, 0, 0], poses[index, 0, 1] = x[index], y[index]
            poses[index, 0, 2], poses[index, 0, 3] = yaw[index], other_speed[index]
            slow = min(0.0, acceleration[index]) if manner.slowing else 0.0
            roll_object(poses[index], 0, steps, yaw_rate[index] if manner.turning else 0.0, slow, interval)
    contact, focus = first_contact(
        points,
        count,
        progress,
        plan_interval,
        tail_speed,
        speed,
        ego_length,
        ego_width,
        -1.0,
        poses,
        length,
        width,
        required,
        0,
        steps,
        -1,
        interval,
    )
    if contact < 0:
        return CLEAR, -1, -1, 0
    if not manner.adaptive:
        return AVOIDED, contact, focus, 5

    slow = min(0.0, acceleration[focus]) if manner.slowing else 0.0
    roll_object(poses[focus], steps, 2 * steps, yaw_rate[focus] if manner.turning else 0.0, slow, interval)
    for fifths in range(6):
        deceleration = 0.2 * fifths * manner.full_brake
        step, _ = first_contact(
            points,
            count,
            progress,
            plan_interval,
            tail_speed,
            speed,
            ego_length,
            ego_width,
            deceleration,
            poses,
            length,
            width,
            required,
            0,
            steps,
            -1,
            interval,
        )
        if step < 0:
            step, _ = first_contact(
                points,
                count,
                progress,
                plan_interval,
                tail_speed,
                speed,
                ego_length,
                ego_width,
                deceleration,
                poses,
                length,
                width,
                required,
                steps + 1,
                2 * steps,
                focus,
                interval,
            )
        if step < 0:
            return AVOIDED, contact, focus, fifths

    best, chosen = -math.inf, -1
    for fifths in range(-1, 6):
        value = merit(
            points,
            count,
            progress,
            plan_interval,
            tail_speed,
            speed,
            ego_length,
            ego_width,
            0.2 * fifths * manner.full_brake,
            poses,
            length,
            width,
            required,
            steps,
            interval,
        )
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
        self._manner = Manner(
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
        outcome, step, index, fifths = predict(
            path.points,
            path.count,
            path.zero,
            path.progress,
            path.interval,
            path.tail_speed,
            speed,
            ego.length,
            ego.width,
            objects.x,
            objects.y,
            objects.yaw,
            objects.speed,
            objects.acceleration,
            objects.yaw_rate,
            objects.length,
            objects.width,
            manner,
        )
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
        return Proposal(score, 0.0, action, (Trigger(number, score),), reason)
