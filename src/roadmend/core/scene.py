"""What can be seen at one tick: the ego and every participant around it."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Objects = NDArray[np.void]  # a table of participants, see OBJECT


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


class EgoState(NamedTuple):
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


OBJECT = np.dtype(
    [
        ("id", np.uint32),
        ("kind", np.uint8),  # ObjectKind
        ("x", np.float64),  # [m] centre of the outline
        ("y", np.float64),  # [m]
        ("yaw", np.float64),  # [rad]
        ("speed", np.float64),  # [m/s] along yaw
        ("acceleration", np.float64),  # [m/s2] along yaw
        ("yaw_rate", np.float64),  # [rad/s]
        ("length", np.float64),  # [m]
        ("width", np.float64),  # [m]
    ],
    align=True,
)
COLUMNS = OBJECT.names or ()


@dataclass(frozen=True, slots=True, eq=False)
class ObjectList:
    """N participants in the map frame: a table of one record each, as kernels read it, and its columns for the rest."""

    table: Objects  # of OBJECT, shape (N,)

    def __len__(self) -> int:
        return len(self.table)

    @classmethod
    def of(cls, **columns: ArrayLike) -> Self:
        """Put a list together from its COLUMNS; a single number in place of a column holds for all participants.

        Raises:
            ValueError: the columns differ in length.
            TypeError: a column is missing or unknown.
        """
        if columns.keys() != set(COLUMNS):
            raise TypeError(f"the columns are {', '.join(COLUMNS)}, not {', '.join(columns)}")
        arrays = {name: np.asarray(column) for name, column in columns.items()}
        count = len(arrays["id"])
        if any(array.shape not in {(count,), ()} for array in arrays.values()):
            raise ValueError("object list: the arrays differ in length")
        return cls(np.empty(count, dtype=OBJECT)).with_columns(**arrays)

    @classmethod
    def empty(cls) -> Self:
        """A list without participants."""
        return cls(np.empty(0, dtype=OBJECT))

    def select(self, keep: NDArray[np.bool_] | NDArray[np.intp]) -> Self:
        """The participants that a mask or an index array names."""
        return type(self)(self.table[keep])

    def with_columns(self, **columns: ArrayLike) -> Self:
        """The same list with other numbers in some of its columns."""
        table = self.table.copy()
        for name, column in columns.items():
            table[name] = column
        return type(self)(table)

    @property
    def id(self) -> NDArray[np.uint32]:
        """Number of each participant."""
        return self.table["id"]

    @property
    def kind(self) -> NDArray[np.uint8]:
        """ObjectKind of each participant."""
        return self.table["kind"]

    @property
    def x(self) -> Floats:
        """Centre of the outline [m]."""
        return self.table["x"]

    @property
    def y(self) -> Floats:
        """Centre of the outline [m]."""
        return self.table["y"]

    @property
    def yaw(self) -> Floats:
        """Heading [rad]."""
        return self.table["yaw"]

    @property
    def speed(self) -> Floats:
        """Speed along the heading [m/s]."""
        return self.table["speed"]

    @property
    def acceleration(self) -> Floats:
        """Acceleration along the heading [m/s2]."""
        return self.table["acceleration"]

    @property
    def yaw_rate(self) -> Floats:
        """Yaw rate [rad/s]."""
        return self.table["yaw_rate"]

    @property
    def length(self) -> Floats:
        """Length of the outline [m]."""
        return self.table["length"]

    @property
    def width(self) -> Floats:
        """Width of the outline [m]."""
        return self.table["width"]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """One tick as every policy and repair method sees it."""

    time: float  # [s] simulation time of the tick
    ego: EgoState
    objects: ObjectList
    signals: NDArray[np.uint8]  # Signal of each traffic light on the route, shape (S,)
