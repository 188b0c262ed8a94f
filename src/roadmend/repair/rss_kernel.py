"""Applies the formulas of Responsibility-Sensitive Safety to every object around the planned path."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.repair.conflict import shared_ground
from roadmend.repair.path import coordinates_on, planned_time
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
    s: float,
    d: float,
    turned: float,
    speed: float,
    ego_length: float,
    ego_width: float,
    other_speed: float,
    length: float,
    width: float,
    law: Law,
) -> tuple[int, float, float, float, float]:
    """What an object at path coordinates s, d is to the ego: kind, danger, braking, distance and safe distance."""
    cosine, sine = math.cos(turned), math.sin(turned)
    half_length = 0.5 * (length * abs(cosine) + width * abs(sine))
    half_width = 0.5 * (length * abs(sine) + width * abs(cosine))
    aside = abs(d) - 0.5 * ego_width - half_width
    closing = other_speed * sine * (-1.0 if d > 0.0 else 1.0)
    if s <= 0.0 or (aside >= 0.0 and aside >= lateral(closing, law)):
        return NONE, -1.0, 0.0, math.inf, 0.0
    distance = s - 0.5 * ego_length - half_length
    along = other_speed * cosine
    if along < -0.5:
        safe = opposite_direction(speed, -along, law)
        return ONCOMING, danger(distance, safe), law.hardest, distance, safe
    along = max(0.0, along)
    safe = same_direction(speed, along, law)
    room = distance + along * along / (2.0 * law.hardest)
    return LEADER, danger(distance, safe), needed_braking(speed, room, law), distance, safe


@compiled
def merging(
    begin: float,
    along: float,
    speed: float,
    ego_length: float,
    other_speed: float,
    length: float,
    has_priority: bool,  # noqa: FBT001 -- compiled code takes no keywords
    arrival: float,
    law: Law,
) -> tuple[int, float, float, float, float]:
    """An object whose way runs into the ego's path from the side, both measured by the distance to where they meet."""
    nothing = (NONE, -1.0, 0.0, math.inf, 0.0)
    if arrival > law.horizon:
        return nothing
    lead = begin - along  # how far the object is ahead of the ego's centre
    distance = abs(lead) - 0.5 * (ego_length + length)
    if lead >= 0.0:
        safe = same_direction(speed, other_speed, law)
        room = distance + other_speed * other_speed / (2.0 * law.hardest)
        return MERGING, danger(distance, safe), needed_braking(speed, room, law), distance, safe
    free = begin - 0.5 * ego_length
    if has_priority or speed * speed / (2.0 * law.hardest) >= free:  # the ego goes first, or cannot help doing so
        return nothing
    safe = same_direction(other_speed, speed, law)
    if stopping_distance(speed, law) < free:  # there is still time to give way
        return nothing
    return MERGING, danger(distance, safe), law.brake, distance, safe


@compiled
def crossing(
    begin: float,
    least: float,
    greatest: float,
    speed: float,
    ego_length: float,
    other_speed: float,
    length: float,
    has_priority: bool,  # noqa: FBT001 -- compiled code takes no keywords
    arrival: float,
    leave: float,
    law: Law,
) -> tuple[int, float, float, float, float]:
    """An object whose way crosses the ego's path: both may not be on the shared ground within one time gap."""
    nothing = (NONE, -1.0, 0.0, math.inf, 0.0)
    other_free = least - 0.5 * length
    other_arrival = max(0.0, other_free / other_speed)
    other_leave = (greatest + 0.5 * length) / other_speed
    together = arrival < other_leave + law.time_gap and other_arrival < leave + law.time_gap
    if not together or min(arrival, other_arrival) > law.horizon:
        return nothing
    if has_priority and stopping_distance(other_speed, law) < other_free:  # it must give way and still can
        return nothing
    free = begin - 0.5 * ego_length
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
def has_priority_at(zones: Floats, number: int, begin: float, end: float) -> bool:
    """Whether one of the zones (rows begin, end along the path [m]) in which the ego goes first touches a stretch."""
    for index in range(number):  # noqa: SIM110 -- any() over a generator does not compile
        if zones[index, 0] <= end and begin <= zones[index, 1]:
            return True
    return False


@compiled
def appraise(
    points: Floats,
    count: int,
    zero: int,
    progress: Floats,
    interval: float,
    tail_speed: float,
    zones: Floats,
    number: int,
    speed: float,
    ego_length: float,
    ego_width: float,
    x: Floats,
    y: Floats,
    yaw: Floats,
    other_speed: Floats,
    yaw_rate: Floats,
    length: Floats,
    width: Floats,
    law: Law,
) -> Floats:
    """Judge N objects; returns shape (N, 5): kind, danger, braking [m/s2], distance [m], safe distance [m]."""
    found = np.zeros((x.shape[0], 5), dtype=np.float64)
    for index in range(x.shape[0]):
        found[index, 1] = -1.0
        s, d, turned = coordinates_on(points, count, x[index], y[index], yaw[index])
        speedy = other_speed[index] > 0.5
        across = speedy and abs(math.cos(turned)) < abs(math.sin(turned))
        if s < 0.0 and abs(d) < 0.5 * (ego_width + width[index]) and math.cos(turned) > 0.5:
            continue  # a follower: the ego is in front and its safety is the follower's duty
        verdict = (NONE, -1.0, 0.0, math.inf, 0.0)
        if not across and s < points[2, count - 1]:
            verdict = on_path(
                s, d, turned, speed, ego_length, ego_width, other_speed[index], length[index], width[index], law
            )
        if verdict[0] == NONE and speedy:
            half_swath = 0.5 * (ego_width + width[index])
            begin, end, least, greatest, crossed = shared_ground(
                points,
                count,
                zero,
                half_swath,
                x[index],
                y[index],
                yaw[index],
                other_speed[index],
                yaw_rate[index],
                0.5 * length[index] + half_swath,
                other_speed[index] * (law.horizon + 1.0),
            )
            if begin < math.inf:
                priority = has_priority_at(zones, number, begin, end)
                arrival = planned_time(progress, interval, tail_speed, begin - 0.5 * ego_length)
                if abs(crossed) < _ALIGNED:
                    verdict = merging(
                        begin, least, speed, ego_length, other_speed[index], length[index], priority, arrival, law
                    )
                else:
                    leave = planned_time(progress, interval, tail_speed, end + 0.5 * ego_length)
                    verdict = crossing(
                        begin,
                        least,
                        greatest,
                        speed,
                        ego_length,
                        other_speed[index],
                        length[index],
                        priority,
                        arrival,
                        leave,
                        law,
                    )
        kind, score, braking, distance, safe = verdict
        found[index, 0], found[index, 1], found[index, 2] = kind, score, braking
        found[index, 3], found[index, 4] = distance, safe
    return found
