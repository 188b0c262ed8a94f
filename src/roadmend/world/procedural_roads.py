"""Motorways and rural roads at random, described as netconvert reads them."""

import math
import random
from itertools import pairwise

from roadmend.world.network import PlainNetwork

_CARRIAGEWAYS = 14.0  # [m] between the reference lines of the two directions
_RAMP_REACH = (220.0, 320.0)  # [m] along the motorway from a junction to where its ramps leave and join
_SIDE = 110.0  # [m] from the motorway to the junctions at the ends of its ramps
_BRIDGE = 7.0  # [m] of the crossing road above the motorway
_ROUNDED = ["--no-turnarounds", "true", "--junctions.corner-detail", "8"]


def describe_motorway(numbers: random.Random) -> PlainNetwork:
    """A motorway with interchanges: two carriageways, ramps with lanes to speed up and slow down, roads over it."""
    plain = PlainNetwork()
    lanes = numbers.randint(2, 3)
    limit = numbers.choice((27.78, 33.33, 36.11))
    places = [0.0]
    for _ in range(numbers.randint(2, 3)):
        places.append(places[-1] + numbers.uniform(950.0, 1500.0))
    end = places[-1] + numbers.uniform(900.0, 1300.0)
    for sign, name in ((-1.0, "east"), (1.0, "west")):
        _carriageway(plain, numbers, name, sign, places[1:], end, lanes, limit)
    for number, place in enumerate(places[1:], 1):
        _crossing_road(plain, numbers, number, place)
    plain.options += [*_ROUNDED, "--ramps.guess", "true", "--ramps.ramp-length", "220"]
    return plain


def _carriageway(
    plain: PlainNetwork,
    numbers: random.Random,
    name: str,
    sign: float,
    places: list[float],
    end: float,
    lanes: int,
    limit: float,
) -> None:
    """One direction from end to end; ``sign`` is -1 eastward, on the south side, and 1 westward, on the north side."""
    y = 0.5 * sign * _CARRIAGEWAYS
    nodes = [(f"{name}_0", 0.0)]
    ramps: list[tuple[str, str, int]] = []  # its node on the motorway, exit or entry, number of the interchange
    for number, place in enumerate(places, 1):
        reach = numbers.uniform(*_RAMP_REACH)
        for kind, x in (("exit", place + sign * reach), ("entry", place - sign * reach)):
            nodes.append((f"{name}_{kind}_{number}", x))
            ramps.append((f"{name}_{kind}_{number}", kind, number))
    nodes.append((f"{name}_1", end))
    nodes.sort(key=lambda node: -sign * node[1])
    for node, x in nodes:
        plain.node(node, x, y)
    for (begin, _), (finish, _) in pairwise(nodes):
        plain.edge(f"{begin}-{finish}", begin, finish, lanes, limit, priority="10", type="motorway")
    where = dict(nodes)
    for node, kind, number in ramps:
        side = f"{'south' if sign < 0 else 'north'}_{number}"
        x, far = where[node], (places[number - 1], sign * _SIDE)
        along = x - (-sign if kind == "entry" else sign) * 90.0
        bend = [(x, y), (along, y + sign * 20.0), far]
        ends = (node, side) if kind == "exit" else (side, node)
        shape = " ".join(f"{px:.2f},{py:.2f}" for px, py in (bend if kind == "exit" else bend[::-1]))
        plain.edge(f"{node}-ramp", *ends, 1, numbers.choice((16.67, 19.44)), priority="5", shape=shape)


def _crossing_road(plain: PlainNetwork, numbers: random.Random, number: int, x: float) -> None:
    """The road that the ramps of an interchange lead to, on a bridge over the motorway."""
    control = numbers.choice(("priority", "traffic_light", "traffic_light"))
    lengths = {"south": -_SIDE - numbers.uniform(200.0, 350.0), "north": _SIDE + numbers.uniform(200.0, 350.0)}
    for side, sign in (("south", -1.0), ("north", 1.0)):
        plain.node(f"{side}_{number}", x, sign * _SIDE, control)
        plain.node(f"{side}_end_{number}", x, lengths[side])
        _both_ways(plain, f"{side}_{number}", f"{side}_end_{number}", 1, 19.44, "8", "")
    middle = f"{x:.2f},{-_SIDE:.2f},0 {x:.2f},-40,{_BRIDGE:g} {x:.2f},40,{_BRIDGE:g} {x:.2f},{_SIDE:.2f},0"
    _both_ways(plain, f"south_{number}", f"north_{number}", 1, 13.89, "8", middle)


def describe_rural(numbers: random.Random) -> PlainNetwork:
    """Winding roads between villages: a lane each way, fast and slow ones, junctions of every sort."""
    plain = PlainNetwork()
    columns, rows = numbers.randint(3, 4), numbers.randint(2, 3)
    spacing = numbers.uniform(420.0, 650.0)
    places = {
        (column, row): (
            (column + numbers.uniform(-0.22, 0.22)) * spacing,
            (row + numbers.uniform(-0.22, 0.22)) * spacing,
        )
        for column in range(columns)
        for row in range(rows)
    }
    for (column, row), (x, y) in places.items():
        sort = numbers.choices(("priority", "right_before_left", "allway_stop", "traffic_light"), (8, 2, 1, 1))[0]
        plain.node(_village(column, row), x, y, sort)
    for (column, row), here in places.items():
        for other in ((column + 1, row), (column, row + 1)):
            is_needed = other[0] == column or row == 0  # a comb, so that every village can be reached
            if other in places and (is_needed or numbers.random() < 0.6):
                _country_road(plain, numbers, (_village(column, row), here), (_village(*other), places[other]))
    for row in range(rows):
        for column, out in ((0, -1.0), (columns - 1, 1.0)):
            name, (x, y) = _village(column, row), places[column, row]
            far = (x + out * numbers.uniform(250.0, 450.0), y + numbers.uniform(-60.0, 60.0))
            plain.node(f"{name}_out", *far)
            _country_road(plain, numbers, (name, (x, y)), (f"{name}_out", far))
    plain.options += _ROUNDED
    return plain


def _village(column: int, row: int) -> str:
    return f"village_{column}_{row}"


def _country_road(
    plain: PlainNetwork,
    numbers: random.Random,
    begin: tuple[str, tuple[float, float]],
    end: tuple[str, tuple[float, float]],
) -> None:
    """A road that swings to both sides of the straight line between two places [m]."""
    (x, y), (to_x, to_y) = begin[1], end[1]
    length = math.hypot(to_x - x, to_y - y)
    across = (-(to_y - y) / length, (to_x - x) / length)
    swing, waves = numbers.uniform(-0.05, 0.05) * length, numbers.choice((1, 2))
    points = []
    for step in range(17):
        share = step / 16
        # Both ends keep their direction, so that junctions meet at fair angles.
        aside = swing * math.sin(math.pi * waves * share) * math.sin(math.pi * share)
        points.append((x + share * (to_x - x) + aside * across[0], y + share * (to_y - y) + aside * across[1]))
    limit, priority = numbers.choice(((13.89, "4"), (19.44, "6"), (22.22, "8"), (27.78, "10")))
    shape = " ".join(f"{px:.2f},{py:.2f}" for px, py in points)
    _both_ways(plain, begin[0], end[0], 1, limit, priority, shape)


def _both_ways(plain: PlainNetwork, begin: str, end: str, lanes: int, limit: float, priority: str, shape: str) -> None:
    """A road with lanes in both directions; ``shape`` leads from begin to end."""
    there = {"priority": priority} | ({"shape": shape} if shape else {})
    back = {"priority": priority} | ({"shape": " ".join(reversed(shape.split()))} if shape else {})
    plain.edge(f"{begin}-{end}", begin, end, lanes, limit, **there)
    plain.edge(f"{end}-{begin}", end, begin, lanes, limit, **back)
