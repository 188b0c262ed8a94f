"""Where every vehicle of an episode was, tick by tick, under the names that a crash report gives them."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from roadmend.core.scene import EgoState, ObjectList
from roadmend.core.tick import INTERVAL
from roadmend.world.participants import Pose

Floats = NDArray[np.float64]


@dataclass(slots=True)
class Film:
    """An episode as it was driven.

    Attributes:
        ego_name: name of the vehicle that the policy drove, as the report has it; "ego" where it has none.
        fixed: names of those that are no vehicles and stand where they are.
        ego: its states, one a tick, the last tick too.
        objects: who was around it, as pictures show them, one list a tick.
        everyone: the others on the map, near or far, by name, one mapping a tick.
    """

    ego_name: str
    ego: list[EgoState] = field(default_factory=list)
    objects: list[ObjectList] = field(default_factory=list)
    everyone: list[dict[str, Pose]] = field(default_factory=list)
    fixed: frozenset[str] = frozenset()

    def add(self, ego: EgoState, objects: ObjectList, others: dict[str, Pose]) -> None:
        """Take in one tick."""
        self.ego.append(ego)
        self.objects.append(objects)
        self.everyone.append(others)

    @property
    def names(self) -> list[str]:
        """All that were seen, the ego first."""
        seen = {name for others in self.everyone for name in others}
        return [self.ego_name, *sorted(seen - {self.ego_name})]

    def poses(self, tick: int) -> dict[str, Pose]:
        """Everybody at a tick, the ego too."""
        ego = self.ego[tick]
        own = Pose(ego.x, ego.y, ego.yaw, ego.speed, ego.length, ego.width)
        return {self.ego_name: own, **self.everyone[tick]}

    def track(self, name: str) -> Floats:
        """Tick, x, y [m], yaw [rad] and speed [m/s] of one vehicle, N x 5, where it was on the map."""
        rows = []
        for tick in range(len(self.ego)):
            pose = self.poses(tick).get(name)
            if pose is not None:
                rows.append((tick, pose.x, pose.y, pose.yaw, pose.speed))
        return np.array(rows, dtype=np.float64).reshape(-1, 5)

    def nearest(self, since: int = 0) -> int:
        """The tick, from one on, at which somebody was nearest to the ego, or the middle if nobody ever was there."""
        gaps = [
            min((math.hypot(pose.x - ego.x, pose.y - ego.y) for pose in others.values()), default=math.inf)
            for ego, others in zip(self.ego, self.everyone, strict=True)
        ]
        best = min(range(since, len(gaps)), key=gaps.__getitem__)
        return best if math.isfinite(gaps[best]) else len(gaps) // 2

    @property
    def duration(self) -> float:
        """Length of the film [s]."""
        return max(0, len(self.ego) - 1) * INTERVAL
