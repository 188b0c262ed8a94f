"""What netconvert writes as OpenDRIVE, brought into the form that ASAM's checker and other readers ask for.

Curves get their true length, lines that go on straight become one, signals and objects get numbers for names, and the
turning loops at a road's dead ends, which no report and no map has, go. The same network gives the same file: no date of
today, no path of this machine.
"""

import itertools
import math
from collections.abc import Callable
from xml.etree import ElementTree as ET

import numpy as np

VERSION = ("1", "7")
_DATE = "2026-01-01T00:00:00"  # the same network gives the same file
_TURNED = math.radians(150.0)  # between an end and the next start, from which on a connection is a turning loop
_STRAIGHT = 1e-6  # [rad] and, times a length, [m] that two lines of one direction may differ by
_STEPS, _NODES = 16, 5  # pieces and nodes of the quadrature of a curve's length


def conform(root: ET.Element) -> None:
    """Change an OpenDRIVE document of netconvert in place."""
    header = root.find("header")
    assert header is not None
    header.set("revMajor", VERSION[0])
    header.set("revMinor", VERSION[1])
    header.set("date", _DATE)
    _remove_turning_loops(root)
    for road in root.findall("road"):
        _merge_lines(road)
        _mend_lengths(road)
    _number(root)


def _remove_turning_loops(root: ET.Element) -> None:
    roads = {road.get("id"): road for road in root.findall("road")}
    for junction in root.findall("junction"):
        connections = junction.findall("connection")
        connecting = [roads[each.get("connectingRoad")] for each in connections]
        if not connections or not all(_turns_round(road, roads) for road in connecting):
            continue
        number = junction.get("id")
        root.remove(junction)
        for road in {id(road): road for road in connecting}.values():
            root.remove(road)
        for road in root.findall("road"):
            link = road.find("link")
            for end in [] if link is None else list(link):
                if end.get("elementType") == "junction" and end.get("elementId") == number and link is not None:
                    link.remove(end)
    for junction in root.findall("junction"):
        if junction.find("connection") is None:
            root.remove(junction)
            for link in root.findall("road/link"):
                for end in list(link):
                    if end.get("elementType") == "junction" and end.get("elementId") == junction.get("id"):
                        link.remove(end)


def _turns_round(road: ET.Element, roads: dict[str | None, ET.Element]) -> bool:
    """Whether a connecting road leads back where its predecessor came from."""
    before, after = (roads.get(_neighbour(road, end)) for end in ("predecessor", "successor"))
    if before is None or after is None:
        return False
    first, last = before.findall("planView/geometry")[-1], after.findall("planView/geometry")[0]
    turn = math.remainder(_number_of(last, "hdg") - _end_heading(first), math.tau)
    return abs(turn) > _TURNED


def _neighbour(road: ET.Element, end: str) -> str | None:
    found = road.find(f"link/{end}")
    return None if found is None else found.get("elementId")


def _end_heading(geometry: ET.Element) -> float:
    heading = _number_of(geometry, "hdg")
    curve = geometry.find("paramPoly3")
    if curve is not None:
        du, dv = _slope(curve, 1.0)
        heading += math.atan2(float(dv), float(du))
    arc = geometry.find("arc")
    if arc is not None:
        heading += _number_of(arc, "curvature") * _number_of(geometry, "length")
    return heading


def _merge_lines(road: ET.Element) -> None:
    """Make one of lines that follow each other in one direction."""
    plan = road.find("planView")
    assert plan is not None
    before: ET.Element | None = None
    for geometry in list(plan):
        if before is not None and before.find("line") is not None and geometry.find("line") is not None:
            length, heading = _number_of(before, "length"), _number_of(before, "hdg")
            x = _number_of(before, "x") + length * math.cos(heading)
            y = _number_of(before, "y") + length * math.sin(heading)
            beside = math.hypot(_number_of(geometry, "x") - x, _number_of(geometry, "y") - y)
            turn = math.remainder(_number_of(geometry, "hdg") - heading, math.tau)
            if abs(turn) <= _STRAIGHT and beside <= 0.01:
                before.set("length", f"{length + _number_of(geometry, 'length'):.8f}")
                plan.remove(geometry)
                continue
        before = geometry


def _mend_lengths(road: ET.Element) -> None:
    """Give curves their true length, and everything along the road the place that follows from it."""
    knots, true, s = [0.0], [0.0], 0.0
    for geometry in road.findall("planView/geometry"):
        told = _number_of(geometry, "length")
        curve = geometry.find("paramPoly3")
        length = told if curve is None else _curve_length(curve, told)
        geometry.set("s", f"{s:.8f}")
        geometry.set("length", f"{length:.8f}")
        s += round(length, 8)
        knots.append(knots[-1] + told)
        true.append(s)
    road.set("length", f"{s:.8f}")
    moved = _interpolation(knots, true)
    for element in road.iter():
        if element.tag != "geometry" and element.get("s") is not None:
            element.set("s", f"{moved(_number_of(element, 's')):.8f}")


def _interpolation(knots: list[float], values: list[float]) -> Callable[[float], float]:
    return lambda place: float(np.interp(place, knots, values))


def _curve_length(curve: ET.Element, told: float) -> float:
    """Length [m] of a parametric cubic, by Gauss and Legendre's quadrature."""
    end = told if curve.get("pRange") == "arcLength" else 1.0
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    total = 0.0
    for low, high in itertools.pairwise(np.linspace(0.0, end, _STEPS + 1)):
        places = 0.5 * (high - low) * nodes + 0.5 * (high + low)
        du, dv = _slope(curve, places)
        total += 0.5 * (high - low) * float((weights * np.hypot(du, dv)).sum())
    return total


def _slope(curve: ET.Element, places: "np.ndarray | float") -> "tuple[np.ndarray | float, np.ndarray | float]":
    b, c, d = ({axis: _number_of(curve, f"{name}{axis}") for axis in "UV"} for name in "bcd")
    du, dv = (b[axis] + 2.0 * c[axis] * places + 3.0 * d[axis] * places * places for axis in "UV")
    return du, dv


def _number(root: ET.Element) -> None:
    """Numbers for the names of signals and objects, from 1, and wherever they are referred to."""
    for tag in ("signal", "object"):
        numbers: dict[str, str] = {}
        for element in root.iter(tag):
            name = element.get("id", "")
            element.set("id", numbers.setdefault(name, str(len(numbers) + 1)))
            element.set("name", element.get("name") or name)
            if tag == "object" and element.get("zOffset") is None:
                element.set("zOffset", "0")
        for reference in root.iter(f"{tag}Reference"):
            reference.set("id", numbers.get(reference.get("id", ""), reference.get("id", "")))
        if tag == "signal":
            for control in root.iter("control"):
                name = control.get("signalId", "")
                control.set("signalId", numbers.get(name, name))


def _number_of(element: ET.Element, name: str) -> float:
    return float(element.get(name, "0"))
