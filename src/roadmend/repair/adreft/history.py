"""What the last second, and the drive so far, add to the tokens of a tick.

Tokens are of one tick. Who is about to cut in shows by a drift that one tick does not tell, the acceleration of one tick is
mostly noise, and how slippery the road is nobody says: but whoever sees less far drives in worse weather, and how hard the
brakes have bitten before is known.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core import portable_math
from roadmend.core.command import Decision
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.repair.adreft.tokenizer import TokenSet

ATTRIBUTES = 4  # columns that are added to every token
SHORT, LONG = 0.5, 1.0  # [s] looked back
# Of a participant: acceleration over SHORT and LONG, sideways drift, how long it has been seen.
BRIEFLY, LATELY, DRIFT, SEEN = range(ATTRIBUTES)
# Of the ego, its row being the last: acceleration over LONG, mean command over it, farthest participant seen so far, hardest
# deceleration so far. Points of the plan have zeros.
OWN, ASKED, FARTHEST, HARDEST = range(ATTRIBUTES)

_ACCELERATION, _DRIFT, _SEEN, _FAR = 4.0, 2.0, 5.0, 150.0  # what a value of 1 stands for [m/s2], [m/s], [s], [m]
_SLACK = 1e-6  # [s] against rounding in sums of ticks
_MOST = 10_000  # participants remembered; beyond that, in a drive of hours, those out of sight are forgotten


class _Past(NamedTuple):
    """What is kept of a tick."""

    time: float  # [s]
    ego: EgoState
    objects: Objects
    asked: float  # throttle - brake


class _Change(NamedTuple):
    """What has changed of P participants; each of shape (P,)."""

    faster: NDArray[np.float64]  # [m/s] than before
    drifted: NDArray[np.float64]  # [m] to the left of its heading
    passed: NDArray[np.float64]  # [s] since then


class History:
    """Follows an episode tick by tick. Stamps that run backwards or a gap in them begin it anew."""

    def __init__(self) -> None:
        self._past: deque[_Past] = deque()  # of the last LONG seconds, this tick included
        self._first_seen: dict[int, float] = {}  # [s] by number
        self._farthest = 0.0  # [m]
        self._hardest = 0.0  # [m/s2]

    def reset(self) -> None:
        """Begin an episode."""
        self._past.clear()
        self._first_seen.clear()
        self._farthest = self._hardest = 0.0

    def see(self, scene: Scene, decision: Decision) -> None:
        """Take in a tick; every one of them, in order."""
        time, ego, table = scene.time, scene.ego, scene.objects.table
        if self._past and not 0.0 < time - self._past[-1].time <= LONG:
            self.reset()
        self._past.append(_Past(time, ego, table, decision.command.action))
        while time - self._past[0].time > LONG + _SLACK:
            self._past.popleft()
        numbers = table["id"].tolist()
        for number in numbers:
            self._first_seen.setdefault(number, time)
        if len(self._first_seen) > max(_MOST, len(numbers)):
            self._first_seen = {number: self._first_seen[number] for number in numbers}
        if len(table):
            far = float(np.sqrt(np.max((table["x"] - ego.x) ** 2 + (table["y"] - ego.y) ** 2)))
            self._farthest = max(self._farthest, min(far, _FAR))
        before = self._before(SHORT)
        if before is not None and time - before.time >= SHORT - _SLACK:
            self._hardest = max(self._hardest, (before.ego.speed - ego.speed) / (time - before.time))

    def extend(self, tokens: TokenSet) -> NDArray[np.float32]:
        """The tokens of the tick seen last with ATTRIBUTES columns more, shape (N, c + ATTRIBUTES).

        Args:
            tokens: of a tokenizer whose last one is the ego's.
        """
        values, now = tokens.values, self._past[-1]
        added = np.zeros((len(values), ATTRIBUTES), dtype=np.float64)
        rows = np.flatnonzero(tokens.object_rows >= 0)
        if len(rows):
            seen = now.objects[tokens.object_rows[rows]]
            briefly, lately = self._since(seen, SHORT), self._since(seen, LONG)
            added[rows, BRIEFLY] = briefly.faster / briefly.passed / _ACCELERATION
            added[rows, LATELY] = lately.faster / lately.passed / _ACCELERATION
            added[rows, DRIFT] = briefly.drifted / briefly.passed / _DRIFT
            added[rows, SEEN] = [min(1.0, (now.time - self._first_seen[one]) / _SEEN) for one in seen["id"].tolist()]
        before = self._before(LONG)
        if before is not None:
            added[-1, OWN] = (now.ego.speed - before.ego.speed) / (now.time - before.time) / _ACCELERATION
        added[-1, ASKED] = math.fsum(each.asked for each in self._past) / len(self._past)
        added[-1, FARTHEST] = self._farthest / _FAR
        added[-1, HARDEST] = self._hardest / _ACCELERATION
        return np.concatenate([values, np.clip(added, -3.0, 3.0).astype(np.float32)], axis=1)

    def _before(self, seconds: float) -> _Past | None:
        """The oldest tick that is no longer ago than that; None where there is none but this one."""
        now = self._past[-1].time
        for each in self._past:
            if now - each.time <= seconds + _SLACK:
                return each if each.time < now else None
        return None

    def _since(self, seen: Objects, seconds: float) -> _Change:
        """What has changed of participants within that time; nothing of who was not there yet."""
        change = _Change(np.zeros(len(seen)), np.zeros(len(seen)), np.full(len(seen), seconds))
        before = self._before(seconds)
        if before is None or not len(before.objects):
            return change
        order = np.argsort(before.objects["id"], kind="stable")
        known = before.objects["id"][order]
        places = np.minimum(np.searchsorted(known, seen["id"]), len(known) - 1)
        there = known[places] == seen["id"]
        then, now = before.objects[order[places[there]]], seen[there]
        change.faster[there] = now["speed"] - then["speed"]
        change.passed[there] = self._past[-1].time - before.time
        # Across its own heading now: to the left is positive.
        dx, dy = now["x"] - then["x"], now["y"] - then["y"]
        change.drifted[there] = dy * portable_math.cos(now["yaw"]) - dx * portable_math.sin(now["yaw"])
        return change
