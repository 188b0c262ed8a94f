"""Who is to blame for a contact: the rules by which nuPlan tells collisions at the ego's fault from others.

After the metric "no at-fault collisions" of the nuPlan benchmark (Karnchanachari et al. 2024, metrics): a contact is at
the ego's fault if the ego drives its front into somebody, hits somebody who stands, or is between two lanes.
"""

import math

import numpy as np

from roadmend.core.geometry import corner_distance, fill_corners, fill_outline
from roadmend.core.outcome import Blame
from roadmend.core.scene import EgoState, ObjectList
from roadmend.world.ego import STANDING

_BUMPER = 0.02  # [m] depth of the outline that counts as the front or the rear


def find_blame(ego: EgoState, others: ObjectList, index: int, *, changing: bool) -> Blame:
    """Tell the kind of a contact.

    Args:
        ego: at the moment of contact.
        others: who is around.
        index: of the one that it met.
        changing: whether the ego is in a lane change.
    """
    if ego.speed < STANDING:
        return Blame.EGO_STOOD
    if others.speed[index] < STANDING:
        return Blame.OTHER_STOOD
    corners, edge = np.empty((4, 2)), np.empty((4, 2))
    fill_outline(corners, others.table[index])
    reach = 0.5 * (ego.length - _BUMPER)
    along_x, along_y = reach * math.cos(ego.yaw), reach * math.sin(ego.yaw)
    fill_corners(edge, ego.x + along_x, ego.y + along_y, ego.yaw, _BUMPER, ego.width)
    if corner_distance(edge, corners) <= 0.0:
        return Blame.FRONT
    if changing:
        return Blame.CHANGING
    fill_corners(edge, ego.x - along_x, ego.y - along_y, ego.yaw, _BUMPER, ego.width)
    return Blame.REAR if corner_distance(edge, corners) <= 0.0 else Blame.SIDE
