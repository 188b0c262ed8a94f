"""Prediction module: every object forward in time, from its own motion alone."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, ObjectKind, Objects

Floats = NDArray[np.float64]
Record = NDArray[np.void]

TIMES = 27  # points in time
FINE = 20  # points at the fine interval, after the present
FINE_INTERVAL = 0.25  # [s]
COARSE_INTERVAL = 0.5  # [s] beyond 5 s, up to 8 s

# Columns of the table of tracks
X, Y, YAW, SPEED, ACCELERATION, CURVATURE, HALF_LENGTH, HALF_WIDTH, PEDESTRIAN, SOURCE = range(10)
TRACK_COLUMNS = 10
# Last axis of the table of forecasts: centre [m], cosine and sine of the heading, way driven [m], speed [m/s]
FX, FY, FCOS, FSIN, FWAY, FSPEED = range(6)
FORECAST_COLUMNS = 6

REMEMBERED = 512  # objects whose filtered curvature is kept
_KNOWN = np.dtype([("id", np.uint32), ("curvature", np.float64)], align=True)  # [1/m]
_PEDESTRIAN = int(ObjectKind.PEDESTRIAN)
_SLOW = 0.5  # [m/s] below which a yaw rate says nothing about the way
_SPEED_GAIN_MAX = 4.0  # [m/s] that an object is taken to gain at most
_CURVATURE_MAX = 0.25  # [1/m]
_STRAIGHT = 0.002  # [1/m]


def nobody_known() -> Record:
    """Room for the filtered curvatures of the objects of a tick."""
    return np.zeros(REMEMBERED, dtype=_KNOWN)


@compiled
def time_at(index: int) -> float:
    """Time [s] of a point of the prediction."""
    return FINE_INTERVAL * index if index <= FINE else FINE_INTERVAL * FINE + COARSE_INTERVAL * (index - FINE)


@compiled
def index_before(time: float) -> int:
    """Last point of the prediction that is not later than ``time`` [s]."""
    end = FINE_INTERVAL * FINE
    index = int(time / FINE_INTERVAL) if time < end else FINE + int((time - end) / COARSE_INTERVAL)
    return min(index, TIMES - 1)


@compiled
def track(
    parameters: Record, known: Record, known_count: int, objects: Objects, interval: float, ego: EgoState, reach: float
) -> tuple[Floats, int]:
    """The objects that matter, with curvatures filtered over time; shape (M, TRACK_COLUMNS).

    Objects that cannot come within ``reach`` [m] of the ego, or that are described by a number which is not finite,
    are left out. ``known`` remembers the filtered curvatures from tick to tick; the new count is returned as the
    second value.
    """
    p = parameters[0]
    count = objects.shape[0]
    tracks = np.empty((count, TRACK_COLUMNS), dtype=np.float64)
    curvatures = np.empty(min(count, REMEMBERED), dtype=np.float64)
    gain = 1.0 - math.exp(-interval / p.yaw_rate_filter) if p.yaw_rate_filter > 0.0 else 1.0
    horizon = time_at(TIMES - 1)
    found = 0
    for index in range(count):
        one = objects[index]
        v = one.speed
        total = one.x + one.y + one.yaw + v + one.acceleration + one.yaw_rate
        usable = math.isfinite(total) and one.length > 0.0 and one.width > 0.0 and one.length + one.width < 1e3
        curvature = 0.0
        if usable and v > _SLOW:
            curvature = min(max(one.yaw_rate / v, -_CURVATURE_MAX), _CURVATURE_MAX)
        before = -1
        if index < known_count and known[index].id == one.id:
            before = index
        else:
            for other in range(known_count):
                if known[other].id == one.id:
                    before = other
                    break
        if before >= 0:
            held = known[before].curvature
            curvature = held if usable and v <= _SLOW else held + gain * (curvature - held)
        if index < REMEMBERED:
            curvatures[index] = curvature
        if not usable:
            continue
        away = math.hypot(one.x - ego.x, one.y - ego.y)
        if away > reach + 0.5 * one.length + max(v, 0.0) * horizon:
            continue
        row = tracks[found]
        row[X], row[Y], row[YAW], row[SPEED] = one.x, one.y, one.yaw, max(v, 0.0)
        row[ACCELERATION], row[CURVATURE] = min(max(one.acceleration, -9.0), 4.0), curvature
        row[HALF_LENGTH], row[HALF_WIDTH] = 0.5 * one.length, 0.5 * one.width
        row[PEDESTRIAN] = 1.0 if one.kind == _PEDESTRIAN else 0.0
        row[SOURCE] = index
        found += 1
    remembered = min(count, REMEMBERED)
    for index in range(remembered):
        known[index].id, known[index].curvature = objects[index].id, curvatures[index]
    return tracks[:found], remembered


@compiled
def forecast(parameters: Record, row: Floats, out: Floats) -> None:
    """Where one track goes: ``out`` has shape (TIMES, FORECAST_COLUMNS).

    Constant acceleration for a short while, then constant speed; the curvature of the way decays. Pedestrians go
    straight on. Nothing is known of lanes, intentions or traffic lights of others: the limit of this module.
    """
    p = parameters[0]
    x, y, yaw, speed = row[X], row[Y], row[YAW], row[SPEED]
    pedestrian = row[PEDESTRIAN] > 0.0
    acceleration = 0.0 if pedestrian else row[ACCELERATION]
    curvature = 0.0 if pedestrian else row[CURVATURE]
    straight = abs(curvature) < _STRAIGHT
    cosine, sine = math.cos(yaw), math.sin(yaw)
    lasting = p.braking_time if acceleration < 0.0 else p.speeding_time
    fade = math.exp(-FINE_INTERVAL / p.yaw_rate_decay)
    way, v = 0.0, speed
    out[0, FX], out[0, FY], out[0, FCOS], out[0, FSIN], out[0, FWAY], out[0, FSPEED] = x, y, cosine, sine, 0.0, speed
    for index in range(1, TIMES):
        time = time_at(index)
        interval = time - time_at(index - 1)
        after = max(0.0, speed + min(acceleration * min(time, lasting), _SPEED_GAIN_MAX))
        step = 0.5 * (v + after) * interval
        v = after
        way += step
        if straight:
            x += step * cosine
            y += step * sine
        else:
            turn = curvature * step
            x += step * math.cos(yaw + 0.5 * turn)
            y += step * math.sin(yaw + 0.5 * turn)
            yaw += turn
            cosine, sine = math.cos(yaw), math.sin(yaw)
            curvature *= fade if index <= FINE else fade * fade
            straight = abs(curvature) < _STRAIGHT
        out[index, FX], out[index, FY], out[index, FCOS], out[index, FSIN] = x, y, cosine, sine
        out[index, FWAY], out[index, FSPEED] = way, v
