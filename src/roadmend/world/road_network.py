"""A SUMO network as read from its .net.xml: lanes with shapes, and the connections between them."""

import functools
import itertools
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.xml_file import read_xml

Floats = NDArray[np.float64]

_DEFAULT_LANE_WIDTH = 3.2  # [m] where the network gives none (SUMO's default)
_MEND = "build the network again with netconvert"


@dataclass(frozen=True, slots=True, eq=False)
class Lane:
    """One lane; ``shape`` is its centre line, P x 2 [m]."""

    id: str
    shape: Floats
    length: float  # [m]
    speed_limit: float  # [m/s]
    width: float  # [m]
    allow: tuple[str, ...] = ()  # SUMO's classes of vehicles; where there are none, all but those of ``disallow``
    disallow: tuple[str, ...] = ()

    def admits(self, vehicle_class: str) -> bool:
        """Whether vehicles of SUMO's class may use it."""
        names = {vehicle_class, "all"}
        return not names.isdisjoint(self.allow) if self.allow else names.isdisjoint(self.disallow)

    @property
    def for_cars(self) -> bool:
        """Whether cars may use it."""
        return self.admits("passenger")

    @property
    def for_pedestrians_only(self) -> bool:
        """Whether it is a sidewalk or a path."""
        return self.allow == ("pedestrian",)


@dataclass(frozen=True, slots=True)
class Edge:
    """One direction of a road; lanes from right to left."""

    id: str
    function: str  # normal, internal, crossing, walkingarea, connector
    lanes: tuple[Lane, ...]
    junctions: tuple[str, ...] = ()  # where it begins and ends, or the one that it is inside of

    @property
    def car_lanes(self) -> tuple[Lane, ...]:
        """The lanes that cars may use, from right to left."""
        return tuple(lane for lane in self.lanes if lane.for_cars)

    def lane_number(self, car_lane: int) -> int:
        """SUMO's index of the n-th lane for cars."""
        return self.lanes.index(self.car_lanes[car_lane])


@dataclass(frozen=True, slots=True)
class Connection:
    """Permission to drive from one lane to another."""

    from_edge: str
    to_edge: str
    from_lane: int
    to_lane: int
    via: str  # internal lane, or empty
    state: str  # SUMO's link state
    direction: str
    traffic_light: str  # or empty
    link_index: int


@dataclass(frozen=True, eq=False)
class RoadNetwork:
    """All edges by id, all connections by (from edge, from lane), and the phases of the traffic lights."""

    path: Path
    edges: dict[str, Edge]
    connections: dict[tuple[str, int], list[Connection]]
    phases: dict[str, list[str]]

    def lane(self, lane_id: str) -> Lane:
        """A lane by SUMO's id."""
        edge, _, number = lane_id.rpartition("_")
        return self.edges[edge].lanes[int(number)]

    @property
    def roads(self) -> list[Edge]:
        """The edges that are roads, not the inside of junctions."""
        return [edge for edge in self.edges.values() if edge.function == "normal"]


def read_network(path: Path) -> RoadNetwork:
    """Read a .net.xml; the result is shared between calls and must not be changed.

    Raises:
        InputError: the file cannot be read, is no SUMO network, or has no lane for cars.
    """
    try:
        return _read(path, path.stat().st_mtime_ns)
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "give a SUMO .net.xml file") from None
    except (KeyError, IndexError, ValueError) as error:  # an attribute that is missing, or no number
        raise InputError(str(path), f"is no SUMO network ({error})", _MEND) from None


@functools.lru_cache(maxsize=64)
def _read(path: Path, _modified: int) -> RoadNetwork:
    edges: dict[str, Edge] = {}
    connections: dict[tuple[str, int], list[Connection]] = {}
    phases: dict[str, list[str]] = {}
    root = read_xml(path, _MEND)
    if root.tag != "net":
        raise InputError(str(path), f"is no SUMO network (its root is <{root.tag}>)", "give a .net.xml file")
    for element in root.iterfind("edge"):
        name, lanes = element.attrib["id"], tuple(map(_lane, element.iterfind("lane")))
        edge = Edge(name, element.get("function", "normal"), lanes, _junctions(element))
        edges[edge.id] = edge
    for element in root.iterfind("connection"):
        connection = _connection(element)
        connections.setdefault((connection.from_edge, connection.from_lane), []).append(connection)
    for element in root.iterfind("tlLogic"):
        states = phases.setdefault(element.attrib["id"], [])
        states.extend(phase.get("state", "") for phase in element.iterfind("phase"))
    if not any(edge.car_lanes for edge in edges.values() if edge.function == "normal"):
        raise InputError(str(path), "the network has no lane for cars", "add roads and build it again with netconvert")
    network = RoadNetwork(path, edges, connections, phases)
    _check_connections(network)
    return network


def _check_connections(network: RoadNetwork) -> None:
    """Raise ValueError where one leads to a lane, or over one, that its edge does not have or that is nowhere."""
    for connection in itertools.chain.from_iterable(network.connections.values()):
        name = f"the connection from {connection.from_edge!r} to {connection.to_edge!r}"
        edge = network.edges.get(connection.to_edge)
        if edge is not None and not 0 <= connection.to_lane < len(edge.lanes):
            raise ValueError(f"{name} leads to lane {connection.to_lane}, which is not there")
        try:
            if connection.via:
                network.lane(connection.via)
        except (KeyError, IndexError, ValueError):
            raise ValueError(f"{name} leads over {connection.via!r}, which is not there") from None


def _junctions(element: ET.Element) -> tuple[str, ...]:
    """Those that an edge touches; the name of an edge inside a junction tells which one it is."""
    name = element.attrib["id"]
    if name.startswith(":"):
        return (name[1:].rpartition("_")[0],)
    return tuple(dict.fromkeys(element.attrib[end] for end in ("from", "to") if end in element.attrib))


def _lane(element: ET.Element) -> Lane:
    points = [point.split(",") for point in element.attrib["shape"].split()]
    shape = np.array([[float(point[0]), float(point[1])] for point in points])
    if len(shape) < 2 or not np.isfinite(shape).all():
        raise ValueError(f"lane {element.attrib['id']!r} has no shape of two points or more")  # nor does SUMO take it
    return Lane(
        id=element.attrib["id"],
        shape=shape,
        length=float(element.attrib["length"]),
        speed_limit=float(element.attrib["speed"]),
        width=float(element.get("width", _DEFAULT_LANE_WIDTH)),
        allow=tuple(element.get("allow", "").split()),
        disallow=tuple(element.get("disallow", "").split()),
    )


def _connection(element: ET.Element) -> Connection:
    get = element.attrib.get
    return Connection(
        from_edge=element.attrib["from"],
        to_edge=element.attrib["to"],
        from_lane=int(element.attrib["fromLane"]),
        to_lane=int(element.attrib["toLane"]),
        via=get("via", ""),
        state=get("state", "M"),
        direction=get("dir", "s"),
        traffic_light=get("tl", ""),
        link_index=int(get("linkIndex", "-1")),
    )


class LaneKind(IntEnum):
    """Mirrors roadmend_msgs/Map.KIND_*."""

    ROAD = 0
    JUNCTION = 1
    WALK = 2


@dataclass(frozen=True, slots=True, eq=False)
class LaneMap:
    """Lane centre lines: L lanes with P points altogether, frame map."""

    begin: NDArray[np.int64]  # index of the first point of each lane, shape (L,)
    kind: NDArray[np.uint8]  # LaneKind, shape (L,)
    width: Floats  # [m] shape (L,)
    x: Floats  # [m] shape (P,)
    y: Floats  # [m] shape (P,)

    def lines(self, kind: LaneKind) -> tuple[list[Floats], Floats]:
        """Centre lines (shape (p, 2) each) and widths [m] of all lanes of one kind that have two points or more."""
        ends = np.append(self.begin[1:], len(self.x))
        points = np.column_stack((self.x, self.y))
        chosen = [index for index in np.flatnonzero(self.kind == kind) if ends[index] - self.begin[index] > 1]
        return [points[self.begin[index] : ends[index]] for index in chosen], self.width[chosen]


def lanes_of(network: RoadNetwork) -> LaneMap:
    """All lanes that have a length."""
    lanes = [(edge, lane) for edge in network.edges.values() for lane in edge.lanes if len(lane.shape) >= 2]
    points = np.concatenate([lane.shape for _, lane in lanes]) if lanes else np.empty((0, 2), dtype=np.float64)
    counts = [len(lane.shape) for _, lane in lanes]
    widths = np.array([lane.width for _, lane in lanes], dtype=np.float32)  # as a message of the map has them
    return LaneMap(
        np.cumsum([0, *counts], dtype=np.int64)[:-1],
        np.array([_kind(edge, lane) for edge, lane in lanes], dtype=np.uint8),
        widths.astype(np.float64),
        np.ascontiguousarray(points[:, 0]),
        np.ascontiguousarray(points[:, 1]),
    )


def _kind(edge: Edge, lane: Lane) -> LaneKind:
    if lane.for_pedestrians_only or edge.function in ("crossing", "walkingarea"):
        return LaneKind.WALK
    return LaneKind.JUNCTION if edge.function == "internal" else LaneKind.ROAD
