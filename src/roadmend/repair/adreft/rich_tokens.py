"""The rich tokens: what the paper's six attributes leave out of a scene.

The paper's tokens (ADReFT section 3.1.1) say where everything is and how large; motion has to be guessed. These add
velocity, acceleration, kind, the place relative to the ego's planned path, the time windows in which the ego and the
participant use the ground that they share, and how near the two would come within the next seconds if the ego went on
as planned, or braked. One token more describes the ego itself: its action, its motion, how long it has stood, and the
conflict zone ahead.
"""

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.jit import unnamed
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.adreft.rich_kernel import (
    ATTRIBUTES,
    HORIZON,
    PLAN_TOKENS,
    bound,
    fill_ego,
    fill_participants,
    fill_plan,
)
from roadmend.repair.adreft.tokenizer import TokenSet
from roadmend.repair.planned_path import PathFinder

_STANDING = 0.3  # [m/s] below this speed the ego stands
_PAUSE = 0.5  # [s] between two ticks beyond which the ego's acceleration is unknown


class RichTokenizer:
    """Tokens of shape (N, ATTRIBUTES), scaled to about 1: participants, then the plan, then the ego.

    Participants farther away than ``reach`` [m] have no token: a stated limit of the sensing range, not a number of
    tokens. Columns are those of ``rich_kernel``.
    """

    name = "rich"
    version = 1  # to be raised whenever the same scene gives other values
    attributes = ATTRIBUTES
    has_ego = True

    def __init__(self, reach: float = 100.0) -> None:
        self._reach = reach
        self._finder = PathFinder()
        self._zones = np.empty((0, 5), dtype=np.float64)
        self._time = 0.0
        self._speed = np.nan
        self._stood = 0.0

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._finder.reset(route)
        rows = [(zone.stage, zone.begin, zone.end, int(zone.rule), zone.signal) for zone in route.zones]
        self._zones = np.array(rows, dtype=np.float64).reshape(-1, 5)
        self._speed, self._stood = np.nan, 0.0

    def tokens(self, scene: Scene, decision: Decision) -> TokenSet:
        """The tokens of one tick."""
        ego, objects = scene.ego, scene.objects
        speed = max(0.0, ego.speed)
        acceleration = self._follow(scene.time, speed)
        path = self._finder.find(ego, decision.trajectory, 20.0 + (speed + 3.0) * HORIZON)
        values = np.empty((len(objects) + PLAN_TOKENS + 1, ATTRIBUTES), dtype=np.float32)
        rows = np.full(len(objects) + PLAN_TOKENS + 1, -1, dtype=np.int32)
        laid, own = unnamed(path), unnamed(ego)
        number = fill_participants(values, rows, self._reach, laid, own, objects.table)
        fill_plan(values[number:], laid)
        action, row = decision.command.action, values[number + PLAN_TOKENS]
        fill_ego(row, own, laid, action, acceleration, self._stood, self._zones, scene.signals)
        count = number + PLAN_TOKENS + 1
        bound(values[:count])
        return TokenSet(values[:count], rows[:count])

    def _follow(self, time: float, speed: float) -> float:
        """The ego's acceleration [m/s2] since the last tick, 0 where there was none."""
        passed = time - self._time
        known = 0.0 < passed <= _PAUSE and not np.isnan(self._speed)
        acceleration = (speed - self._speed) / passed if known else 0.0
        self._stood = self._stood + passed if known and speed < _STANDING else 0.0
        self._time, self._speed = time, speed
        return float(acceleration)
