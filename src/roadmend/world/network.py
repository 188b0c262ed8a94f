"""Road networks: plain descriptions, built with netconvert and kept in a cache."""

import hashlib
import math
import subprocess
import tempfile
from pathlib import Path
from xml.etree import ElementTree as ET

from roadmend.core.errors import InputError, SimulationError
from roadmend.core.resources import cache_folder
from roadmend.world.scenario_networks import (
    CENTRE,
    HighwayExitNetwork,
    IntersectionNetwork,
    Network,
    NetworkFile,
    OnRampNetwork,
    OpenRoadNetwork,
    SumoConfiguration,
)
from roadmend.world.user_configuration import network_of

_BUILDER_VERSION = "2"  # raise when the same description shall give another network
_NODE_TYPES = {
    "priority": "priority",
    "priority_stop": "priority_stop",
    "right_before_left": "right_before_left",
    "allway_stop": "allway_stop",
    "traffic_light": "traffic_light",
}
_RAMP_ANGLE = math.radians(14.0)  # between the far end of a ramp and the highway
_RAMP_POINTS = 16
_BEND_STEP = math.radians(4.0)  # between two points of a bend
LANE_WIDTH = 3.2  # [m] SUMO's default


class PlainNetwork:
    """Nodes, edges and connections as netconvert reads them."""

    def __init__(self) -> None:
        self.nodes = ET.Element("nodes")
        self.edges = ET.Element("edges")
        self.connections = ET.Element("connections")
        self.options: list[str] = []
        self.phase = 0.0  # [s] of the traffic light's cycle that have passed at the start

    def node(self, name: str, x: float, y: float, kind: str = "priority") -> None:
        """A node at a point [m]."""
        ET.SubElement(self.nodes, "node", id=name, x=f"{x:.3f}", y=f"{y:.3f}", type=kind)

    def edge(self, name: str, begin: str, end: str, lanes: int, speed: float, **more: str) -> None:
        """A straight one-way road; ``speed`` is its limit [m/s]."""
        ET.SubElement(
            self.edges,
            "edge",
            {"id": name, "from": begin, "to": end, "numLanes": str(lanes), "speed": f"{speed:.3f}"} | more,
        )

    def connection(self, begin: str, end: str, from_lane: int, to_lane: int) -> None:
        """A connection between two lanes."""
        ET.SubElement(
            self.connections,
            "connection",
            {"from": begin, "to": end, "fromLane": str(from_lane), "toLane": str(to_lane)},
        )

    def texts(self) -> tuple[str, str, str]:
        """The three XML documents."""
        nodes, edges, connections = (
            ET.tostring(element, encoding="unicode") for element in (self.nodes, self.edges, self.connections)
        )
        return nodes, edges, connections


def describe_intersection(spec: IntersectionNetwork) -> PlainNetwork:
    """Arms around one node in the origin."""
    plain = PlainNetwork()
    plain.node(CENTRE, 0.0, 0.0, _NODE_TYPES[spec.control])
    for arm in spec.arms:
        angle = math.radians(arm.bearing)
        far = arm.length * math.cos(angle), arm.length * math.sin(angle)
        plain.node(arm.name, *far, "dead_end")
        more = {"priority": "10" if arm.major else "5"}
        into, out = dict(more), dict(more)
        if arm.median:  # each direction's own edge of the road, seen in its direction, lies half a median to the right
            into["shape"] = _shape(_to_the_right([far, (0.0, 0.0)], 0.5 * arm.median))
            out["shape"] = _shape(_to_the_right([(0.0, 0.0), far], 0.5 * arm.median))
        plain.edge(f"{arm.name}_in", arm.name, CENTRE, arm.lanes, arm.speed_limit, **into)
        plain.edge(f"{arm.name}_out", CENTRE, arm.name, arm.lanes_out or arm.lanes, arm.speed_limit, **out)
    plain.options += ["--no-turnarounds", "true", "--junctions.corner-detail", "8"]
    plain.options += ["--tls.cycle.time", str(round(spec.cycle))]
    plain.phase = spec.phase
    if spec.crossings:
        plain.options += ["--sidewalks.guess", "true", "--sidewalks.guess.min-speed", "0"]
        plain.options += ["--sidewalks.guess.max-speed", "100", "--crossings.guess", "true"]
        plain.options += ["--crossings.guess.speed-threshold", "100"]
    return plain


def describe_highway_exit(spec: HighwayExitNetwork) -> PlainNetwork:
    """Eastbound highway; the ramp leaves to the right."""
    plain = PlainNetwork()
    first, second = spec.approach_length, spec.approach_length + spec.lane_length
    plain.node("begin", 0.0, 0.0)
    plain.node("widen", first, 0.0)
    plain.node("split", second, 0.0)
    plain.node("end", second + 300.0, 0.0)
    side = -LANE_WIDTH * spec.lanes
    curve = [(second + x, side - y) for x, y in _ramp_curve(spec.ramp_length)]
    plain.node("ramp_end", *curve[-1])
    plain.edge("approach", "begin", "widen", spec.lanes, spec.speed_limit)
    plain.edge("diverge", "widen", "split", spec.lanes + 1, spec.speed_limit)
    plain.edge("mainline", "split", "end", spec.lanes, spec.speed_limit)
    plain.edge("ramp", "split", "ramp_end", 1, spec.ramp_speed_limit, shape=_shape(curve))
    for lane in range(spec.lanes):
        plain.connection("approach", "diverge", lane, lane + 1)
        plain.connection("diverge", "mainline", lane + 1, lane)
    plain.connection("diverge", "ramp", 0, 0)
    return plain


def describe_on_ramp(spec: OnRampNetwork) -> PlainNetwork:
    """A highway, eastbound or as its bearing says; the ramp comes in from the right."""
    plain = PlainNetwork()
    first, second = spec.approach_length, spec.approach_length + spec.lane_length
    for name, along in (("begin", 0.0), ("join", first), ("narrow", second), ("end", second + 300.0)):
        plain.node(name, *_turned(along, 0.0, spec.bearing))
    side = -LANE_WIDTH * spec.lanes
    curve = [_turned(first - x, side - y, spec.bearing) for x, y in reversed(_ramp_curve(spec.ramp_length))]
    plain.node("ramp_begin", *curve[0])
    plain.edge("approach", "begin", "join", spec.lanes, spec.speed_limit)
    plain.edge("ramp", "ramp_begin", "join", 1, spec.ramp_speed_limit, shape=_shape(curve))
    plain.edge("merge", "join", "narrow", spec.lanes + 1, spec.speed_limit)
    plain.edge("mainline", "narrow", "end", spec.lanes, spec.speed_limit)
    for lane in range(spec.lanes):
        plain.connection("approach", "merge", lane, lane + 1)
        plain.connection("merge", "mainline", lane + 1, lane)
    plain.connection("ramp", "merge", 0, 0)
    return plain


def _turned(x: float, y: float, bearing: float) -> tuple[float, float]:
    """A point [m] of an eastbound road after the road was turned to a bearing [deg]."""
    if not bearing:
        return x, y
    angle = math.radians(bearing)
    return x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle)


def describe_road(spec: OpenRoadNetwork) -> PlainNetwork:
    """A road whose middle, that of its bend too, lies in the origin."""
    line = _bent_line(spec)
    plain = PlainNetwork()
    plain.node("begin", *line[0], "dead_end")
    plain.node("end", *line[-1], "dead_end")
    forward, backward = line, line[::-1]
    if spec.median:
        forward, backward = (_to_the_right(each, 0.5 * spec.median) for each in (forward, backward))
    plain.edge("forward", "begin", "end", spec.lanes, spec.speed_limit, shape=_shape(forward))
    if spec.backward_lanes:
        plain.edge("backward", "end", "begin", spec.backward_lanes, spec.backward_speed_limit, shape=_shape(backward))
    return plain


def _to_the_right(line: list[tuple[float, float]], offset: float) -> list[tuple[float, float]]:
    """A line [m] moved to its right by an offset [m]."""
    moved = []
    for place, (x, y) in enumerate(line):
        before, after = line[max(place - 1, 0)], line[min(place + 1, len(line) - 1)]
        heading = math.atan2(after[1] - before[1], after[0] - before[0])
        moved.append((x + offset * math.sin(heading), y - offset * math.cos(heading)))
    return moved


def _bent_line(spec: OpenRoadNetwork) -> list[tuple[float, float]]:
    """The reference line [m] of a road: half its length straight on, the bend, half its length straight on."""
    bend, heading = math.radians(spec.bend), math.radians(spec.bearing)
    half, steps = 0.5 * spec.length, math.ceil(abs(bend) / _BEND_STEP)
    points = [(0.0, 0.0), (half * math.cos(heading), half * math.sin(heading))]
    for _ in range(steps):
        heading += 0.5 * bend / steps
        chord = 2.0 * spec.radius * math.sin(0.5 * abs(bend) / steps)
        points.append((points[-1][0] + chord * math.cos(heading), points[-1][1] + chord * math.sin(heading)))
        heading += 0.5 * bend / steps
    points.append((points[-1][0] + half * math.cos(heading), points[-1][1] + half * math.sin(heading)))
    # The bend's middle is a point of it, or lies between two.
    one, other = (points[1 + steps // 2], points[1 + (steps + 1) // 2]) if steps else (points[1], points[1])
    x, y = 0.5 * (one[0] + other[0]), 0.5 * (one[1] + other[1])
    return [(px - x, py - y) for px, py in points]


def _ramp_curve(length: float) -> list[tuple[float, float]]:
    """A clothoid-like bend [m] that begins along the highway and ends at the ramp's angle, away from it."""
    points, x, y = [(0.0, 0.0)], 0.0, 0.0
    step = length / _RAMP_POINTS
    for index in range(_RAMP_POINTS):
        heading = _RAMP_ANGLE * min(1.0, (index + 0.5) / (0.75 * _RAMP_POINTS))
        x, y = x + step * math.cos(heading), y + step * math.sin(heading)
        points.append((x, y))
    return points


def _shape(points: list[tuple[float, float]]) -> str:
    return " ".join(f"{x:.3f},{y:.3f}" for x, y in points)


def network_file(network: Network) -> Path:
    """The SUMO network of a scenario, built if it is not in the cache.

    Raises:
        InputError: the description gives no usable network, or its file is not there.
    """
    match network:
        case IntersectionNetwork():
            return _build(describe_intersection(network))
        case HighwayExitNetwork():
            return _build(describe_highway_exit(network))
        case OnRampNetwork():
            return _build(describe_on_ramp(network))
        case OpenRoadNetwork():
            return _build(describe_road(network))
        case NetworkFile():
            path = Path(network.path)
            if not path.is_file():
                raise InputError("network.path", f"no such file {path}", "give the path of a SUMO .net.xml file")
            return path
        case SumoConfiguration():
            return network_of(Path(network.path))


def _build(plain: PlainNetwork) -> Path:
    texts = plain.texts()
    phase = [f"phase {plain.phase:g}"] if plain.phase else []
    key = "\0".join([_BUILDER_VERSION, _netconvert_version(), *texts, *plain.options, *phase])
    target = cache_folder() / "networks" / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.net.xml"
    if target.exists():
        return target
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent) as folder:
            built = netconvert(Path(folder), texts, plain.options)
            if plain.phase:  # netconvert has no option for it
                network = built.read_text(encoding="utf-8").replace(' offset="0"', f' offset="-{plain.phase:g}"')
                built.write_text(network, encoding="utf-8")
            built.replace(target)
    except OSError as error:
        raise InputError(
            str(target.parent), f"cannot be written ({error.strerror})", "set ROADMEND_CACHE to a writable folder"
        ) from None
    return target


def netconvert(folder: Path, texts: tuple[str, str, str], options: list[str]) -> Path:
    """Build a network in a folder from its nodes, edges and connections.

    Raises:
        SimulationError: netconvert failed.
    """
    names = ("nodes.nod.xml", "edges.edg.xml", "connections.con.xml")
    for name, text in zip(names, texts, strict=True):
        (folder / name).write_text(text, encoding="utf-8")
    target = folder / "built.net.xml"
    command = [
        str(find_binary("netconvert")),
        "--node-files",
        names[0],
        "--edge-files",
        names[1],
        "--output-file",
        target.name,
        "--offset.disable-normalization",
        "true",
        "--no-warnings",
        "true",
        *options,
    ]
    if "<connection " in texts[2]:
        command += ["--connection-files", names[2]]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0 or not target.exists():
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        raise SimulationError(f"netconvert failed: {lines[0] if lines else 'no reason given'}")
    return target


def find_binary(name: str) -> Path:
    """A program of SUMO."""
    import sumo  # noqa: PLC0415 - importing it is slow and only a cache miss needs it

    return Path(sumo.SUMO_HOME) / "bin" / name


def _netconvert_version() -> str:
    from importlib.metadata import version  # noqa: PLC0415 - 20 ms that most runs do not need

    return version("eclipse-sumo")
