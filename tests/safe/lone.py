"""Crashes of one vehicle alone, for the tests of how they are played and judged."""

from dataclasses import replace

from roadmend.safe.construction import CrashRole
from roadmend.safe.dsl import DescribedImpact, Side, StruckObject

from .crashes import crash, vehicle


def lone(road="Straight", thing="Tree", part=None, roadside=None, *, position="N2S", lanes=2, bend=None, **more):
    """A vehicle that strikes a thing with a part, on a side of its road."""
    what = crash(road, vehicle(position, limit=45, manoeuvre="Run off the Road"), lanes=lanes, **more)
    impact = DescribedImpact(1, thing and StruckObject(thing), part and Side(part), roadside and Side(roadside))
    return replace(what, impacts=(impact,) if thing else (), road=replace(what.road, bend=bend and Side(bend)))


def onlooker(what, report="sample"):
    return CrashRole(report, what, None)


LONE = {
    "right": lone(part="Front", roadside="Right"),
    "left": lone(thing="Pole", part="Left", roadside="Left"),
    "against the side": lone(thing="Pole", part="Left", roadside="Right"),
    "barrier": lone(thing="Barrier", roadside="Right"),
    "ditch": lone(thing="Ditch", roadside="Left", lanes=4),
    "curb": lone(thing="Curb", part="Front", roadside="Right"),
    "trailer": lone(thing="Parked Trailer", part="Left", roadside="Left"),
    "bend": lone("Curve", bend="Right"),
    "inside": lone("Curve", part="Right", roadside="Right", bend="Right"),
    "animal": lone(thing="Animal", part="Front", lanes=4),
    "junction": lone("T-intersection", roadside="Right", stem="West"),
    "end of the road": lone("T-intersection", thing="Wall", stem="North", lanes=2),
    "ramp": lone("Merging", roadside="Right", position="On-ramp", lanes=4),
    "unsaid": lone(thing="Other"),
}
