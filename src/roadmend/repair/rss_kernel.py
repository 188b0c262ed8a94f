"""Applies the formulas of Responsibility-Sensitive Safety to every object around the planned path."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import Outline
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, Objects
from roadmend.repair.conflict import SharedGround, shared_ground
from roadmend.repair.planned_path import PlannedPath, coordinates_on, planned_time
from roadmend.repair.rss_law import Law, lateral, opposite_direction, same_direction, stopping_distance

Floats = NDArray[np.float64]

NONE, LEADER, ONCOMING, MERGING, CROSSING = 0, 1, 2, 3, 4  # what an object is to the ego
_ALIGNED = 0.6  # [rad] ways that differ less go the same way


@compiled
def danger(distance: float, safe: float) -> float:
    """1 - distance / safe, brought into [-1, 1]: positive where the distance is not safe."""
    if safe <= 0.0:
        return 1.0 if distance < 0.0 else -1.0
    return min(1.0, max(-1.0, 1.0 - distance / safe))


@compiled
def needed_braking(speed: float, distance: float, law: Law) -> float:
    """Deceleration [m/s2] that stops the ego in ``distance`` [m], between that of a proper response and the hardest."""
    if distance <= 0.0:
        return law.hardest
    return min(law.hardest, max(law.brake, speed * speed / (2.0 * distance)))


@compiled
def on_path(
    s: float, d: float, turned: float, speed: float, ego: EgoState, other: Outline, law: Law
) -> tuple[int, float, float, float, float]:
    """What an object at path coordinates s, d is to the ego: kind, danger, braking, distance and safe distance."""
    length, width = other.length, other.width
    cosine, sine = math.cos(turned), math.sin(turned)
    half_length = 0.5 * (length * abs(cosine) + width * abs(sine))
    half_width = 0.5 * (length * abs(sine) + width * abs(cosine))
    aside = abs(d) - 0.5 * ego.width - half_width
    closing = other.speed * sine * (-1.0 if d > 0.0 else 1.0)
    if s <= 0.0 or (aside >= 0.0 and aside >= lateral(closing, law)):
        return NONE, -1.0, 0.0, math.inf, 0.0
    distance = s - 0.5 * ego.length - half_length
    along = other.speed * cosine
    if along < -0.5:
        safe = opposite_direction(speed, -along, law)
        return ONCOMING, danger(distance, safe), law.hardest, distance, safe
    along = max(0.0, along)
    safe = same_direction(speed, along, law)
    room = distance + along * along / (2.0 * law.hardest)
    return LEADER, danger(distance, safe), needed_braking(speed, room, law), distance, safe


@compiled
def merging(
    ground: SharedGround,
    speed: float,
    ego: EgoState,
    other: Outline,
    has_priority: bool,  # noqa: FBT001 -- compiled code takes no keywords
    arrival: float,
    law: Law,
) -> tuple[int, float, float, float, float]:
    """An object whose way runs into the ego's path from the side, both measured by the distance to where they meet."""
    nothing = (NONE, -1.0, 0.0, math.inf, 0.0)
    if arrival > law.horizon:
        return nothing
    lead = ground.begin - ground.least  # how far the object is ahead of the ego's centre
    distance = abs(lead) - 0.5 * (ego.length + other.length)
    if lead >= 0.0:
        safe = same_direction(speed, other.speed, law)
        room = distance + other.speed * other.speed / (2.0 * law.hardest)
        return MERGING, danger(distance, safe), needed_braking(speed, room, law), distance, safe
    free = ground.begin - 0.5 * ego.length
    if has_priority or speed * speed / (2.0 * law.hardest) >= free:  # the ego goes first, or cannot help doing so
        return nothing
    safe = same_direction(other.speed, speed, law)
    if stopping_distance(speed, law) < free:  # there is still time to give way
        return nothing
    return MERGING, danger(distance, safe), law.brake, distance, safe


@compiled
def crossing(
    ground: SharedGround,
    speed: float,
    ego: EgoState,
    other: Outline,
    has_priority: bool,  # noqa: FBT001 -- compiled code takes no keywords
    arrival: float,
    leave: float,
    law: Law,
) -> tuple[int, float, float, float, float]:
    """An object whose way crosses the ego's path: both may not be on the shared ground within one time gap."""
    nothing = (NONE, -1.0, 0.0, math.inf, 0.0)
    other_free = ground.least - 0.5 * other.length
    other_arrival = max(0.0, other_free / other.speed)
    other_leave = (ground.greatest + 0.5 * other.length) / other.speed
    together = arrival < other_leave + law.time_gap and other_arrival < leave + law.time_gap
    if not together or min(arrival, other_arrival) > law.horizon:
        return nothing
    if has_priority and stopping_distance(other.speed, law) < other_free:  # it must give way and still can
        return nothing
    free = ground.begin - 0.5 * ego.length
    safe = stopping_distance(speed, law)
    if free > 0.0 and free * 2.0 * law.hardest > speed * speed:
        return CROSSING, danger(free, safe), needed_braking(speed, free, law), free, safe
    if other_arrival > arrival:  # too late to stop and the ego is first: only a late enough arrival helps
        if free <= 0.0:
            return nothing
        slowed = math.sqrt(speed * speed - 2.0 * law.hardest * free)
        if (speed - slowed) / law.hardest < other_leave:
            return nothing
    return CROSSING, 1.0, law.hardest, free, safe


@compiled
def has_priority_at(zones: Floats, begin: float, end: float) -> bool:
    """Whether one of the zones (rows begin, end along the path [m]) in which the ego goes first touches a stretch."""
    for index in range(zones.shape[0]):  # noqa: SIM110 -- any() over a generator does not compile
        if zones[index, 0] <= end and begin <= zones[index, 1]:
            return True
    return False


@compiled
def appraise(path: PlannedPath, zones: Floats, speed: float, ego: EgoState, objects: Objects, law: Law) -> Floats:
    """Judge N objects; returns shape (N, 5): kind, danger, braking [m/s2], distance [m], safe distance [m].

    ``speed`` is taken for the ego's own; ``zones`` are those in which it goes first, see has_priority_at.
    """
    path, ego, law = PlannedPath(*path), EgoState(*ego), Law(*law)
    found = np.zeros((objects.shape[0], 5), dtype=np.float64)
    for index in range(objects.shape[0]):
        other = objects[index]
        found[index, 1] = -1.0
        s, d, turned = coordinates_on(path, other.x, other.y, other.yaw)
        speedy = other.speed > 0.5
        across = speedy and abs(math.cos(turned)) < abs(math.sin(turned))
        if s < 0.0 and abs(d) < 0.5 * (ego.width + other.width) and math.cos(turned) > 0.5:
            continue  # a follower: the ego is in front and its safety is the follower's duty
        verdict = (NONE, -1.0, 0.0, math.inf, 0.0)
        if not across and s < path.points[2, path.size - 1]:
            verdict = on_path(s, d, turned, speed, ego, other, law)
        if verdict[0] == NONE and speedy:
            half_swath = 0.5 * (ego.width + other.width)
            ahead = other.speed * (law.horizon + 1.0)
            ground = shared_ground(path, other, half_swath, 0.5 * other.length + half_swath, ahead)
            if ground.begin < math.inf:
                priority = has_priority_at(zones, ground.begin, ground.end)
                arrival = planned_time(path, ground.begin - 0.5 * ego.length)
                if abs(ground.turned) < _ALIGNED:
                    verdict = merging(ground, speed, ego, other, priority, arrival, law)
                else:
                    leave = planned_time(path, ground.end + 0.5 * ego.length)
                    verdict = crossing(ground, speed, ego, other, priority, arrival, leave, law)
        kind, score, braking, distance, safe = verdict
        found[index, 0], found[index, 1], found[index, 2] = kind, score, braking
        found[index, 3], found[index, 4] = distance, safe
    return found
