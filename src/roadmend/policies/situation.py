"""What one pass of a policy's compiled modules works on: where the ego is, who is around, what is remembered."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, Objects
from roadmend.policies import localisation, path_ahead, prediction
from roadmend.policies.path_ahead import PathAhead
from roadmend.policies.road import RouteTables

Floats = NDArray[np.float64]
Record = NDArray[np.void]


def pack(values: Mapping[str, float]) -> Record:
    """Numbers as one record, shape (1,), which compiled code reads and writes by name."""
    record: Record = np.zeros(1, dtype=np.dtype([(name, np.float64) for name in values], align=True))
    record[0] = tuple(values.values())
    return record


class Driver(NamedTuple):
    """What a policy brings along from tick to tick."""

    parameters: Record
    memory: Record
    known: Record  # see prediction.nobody_known


class Others(NamedTuple):
    """M tracks, and what is made of them."""

    tracks: Floats  # (M, TRACK_COLUMNS)
    forecasts: Floats  # (M, TIMES, FORECAST_COLUMNS)
    occupancies: Floats  # (M, TIMES, 2)
    agents: Floats  # (M, AGENT_COLUMNS)


class Situation(NamedTuple):
    """All that the modules read at one tick; of it they write the memory and what is made of the others."""

    route: RouteTables
    path: PathAhead
    parameters: Record
    memory: Record
    signals: NDArray[np.uint8]
    ego: EgoState
    others: Others
    time: float  # [s]
    interval: float  # [s] since the last pass


@compiled
def perceive(
    route: RouteTables, driver: Driver, ego: EgoState, objects: Objects, time: float, interval: float
) -> tuple[PathAhead, Floats]:
    """Find the ego's place on its route; returns the path ahead and the tracks of those who matter on it."""
    m = driver.memory[0]
    stage = m.stage
    localisation.localise(route, driver.parameters, driver.memory, ego)
    if stage >= 0.0 and m.stage > stage:
        m.changed_at = time
    path = path_ahead.build_path(route, driver.parameters, driver.memory, ego)
    reach = path.spacing * path_ahead.POINTS
    tracks, m.known_count = prediction.track(
        driver.parameters, driver.known, int(m.known_count), objects, interval, ego, reach
    )
    return path, tracks
