"""Who leaves the lanes and runs into something that stands there.

SUMO knows nothing of what stands beside its roads. A steered vehicle that strikes something firm stands from then on where
it struck: what a tree does to a car in a tenth of a second is no braking, and no part of how the car was driven. What is
not firm, as an animal or a ditch, does not stop it.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from roadmend.core.geometry import corner_distance, fill_outline, wrap_angle
from roadmend.world.obstacle import Obstacle
from roadmend.world.participants import Pose
from roadmend.world.steering import SteeredVehicle


class Impacts:
    """The obstacles of an episode.

    Attributes:
        standing: all of them by name, in the map frame.
    """

    def __init__(self, obstacles: Sequence[Obstacle], *, is_users: bool = False) -> None:
        """Put them where they stand.

        Args:
            obstacles: of the scenario.
            is_users: whether the traffic is a user's own, where a vehicle may have the name of an obstacle.
        """
        names = {each.id: f"obstacle {each.id}" if is_users else each.id for each in obstacles}
        self.standing: Mapping[str, Pose] = MappingProxyType({names[each.id]: pose_of(each) for each in obstacles})
        self._firm = [self.standing[names[each.id]] for each in obstacles if each.firm]

    def step(self, steered: Iterable[SteeredVehicle]) -> None:
        """After everybody has moved for a tick: who strikes something firm is a wreck."""
        for vehicle in steered if self._firm else ():
            if not vehicle.is_wrecked and any(_touch(vehicle.pose, pose) for pose in self._firm):
                vehicle.is_wrecked = True


def pose_of(obstacle: Obstacle) -> Pose:
    """Where an obstacle stands, in the map frame."""
    yaw = wrap_angle(math.radians(obstacle.heading))
    return Pose(obstacle.x, obstacle.y, yaw, 0.0, obstacle.length, obstacle.width)


def _touch(one: Pose, other: Pose) -> bool:
    reach = 0.5 * (math.hypot(one.length, one.width) + math.hypot(other.length, other.width))
    if math.hypot(one.x - other.x, one.y - other.y) > reach:
        return False
    corners, their = np.empty((4, 2)), np.empty((4, 2))
    fill_outline(corners, one)
    fill_outline(their, other)
    return corner_distance(corners, their) <= 0.0
