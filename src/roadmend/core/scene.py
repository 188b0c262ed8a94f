"""What can be seen at one tick: the ego and every participant around it."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class ObjectKind(IntEnum):
    """Category of a participant; mirrors roadmend_msgs/ObjectList.KIND_*."""

    UNKNOWN = 0
    CAR = 1
    TRUCK = 2
    BUS = 3
    MOTORCYCLE = 4
    BICYCLE = 5
    PEDESTRIAN = 6


class Signal(IntEnum):
    """Colour of a traffic light; mirrors roadmend_msgs/ObjectList.SIGNAL_*."""

    GREEN = 0
    YELLOW = 1
    RED = 2
    OFF = 3


@dataclass(frozen=True, slots=True)
class EgoState:
    """Pose and motion of the ego's centre in the map frame.

    The heading is held as the quaternion's z and w because that is what travels in nav_msgs/Odometry: yaw is computed
    from them in one place, so a node and the in-process runner see the same bits.
    """

    x: float  # [m]
    y: float  # [m]
    orientation_z: float
    orientation_w: float
    speed: float  # [m/s]
    yaw_rate: float  # [rad/s]
    length: float  # [m]
    width: float  # [m]
    yaw: float  # [rad]

    @classmethod
    def from_quaternion(
        cls,
        x: float,
        y: float,
        orientation_z: float,
        orientation_w: float,
        speed: float,
        yaw_rate: float,
        length: float,
        width: float,
    ) -> Self:
        """Build the state from what an odometry message carries."""
        yaw = 2.0 * math.atan2(orientation_z, orientation_w)
        return cls(x, y, orientation_z, orientation_w, speed, yaw_rate, length, width, yaw)

    @classmethod
    def from_yaw(
        cls, x: float, y: float, yaw: float, speed: float, yaw_rate: float, length: float, width: float
    ) -> Self:
        """Build the state from a heading in (-pi, pi] [rad]."""
        return cls.from_quaternion(x, y, math.sin(0.5 * yaw), math.cos(0.5 * yaw), speed, yaw_rate, length, width)


@dataclass(frozen=True, slots=True, eq=False)
class ObjectList:
    """N participants as a structure of arrays, each of shape (N,), in the map frame."""

    id: NDArray[np.uint32]
    kind: NDArray[np.uint8]
    x: Floats  # [m] centre of the outline
    y: Floats  # [m]
    yaw: Floats  # [rad]
    speed: Floats  # [m/s] along yaw
    acceleration: Floats  # [m/s2] along yaw
    yaw_rate: Floats  # [rad/s]
    length: Floats  # [m]
    width: Floats  # [m]

    def __len__(self) -> int:
        return len(self.id)

    @classmethod
    def empty(cls) -> Self:
        """A list without participants."""
        none = np.empty(0, dtype=np.float64)
        return cls(
            np.empty(0, dtype=np.uint32),
            np.empty(0, dtype=np.uint8),
            none,
            none,
            none,
            none,
            none,
            none,
            none,
            none,
        )

    def select(self, keep: NDArray[np.bool_] | NDArray[np.intp]) -> "ObjectList":
        """The participants that a mask or an index array names."""
        return ObjectList(
            self.id[keep],
            self.kind[keep],
            self.x[keep],
            self.y[keep],
            self.yaw[keep],
            self.speed[keep],
            self.acceleration[keep],
            self.yaw_rate[keep],
            self.length[keep],
            self.width[keep],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """One tick as every policy and repair method sees it."""

    time: float  # [s] simulation time of the tick
    ego: EgoState
    objects: ObjectList
    signals: NDArray[np.uint8]  # Signal of each traffic light on the route, shape (S,)
