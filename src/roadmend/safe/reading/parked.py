"""Directions in which parked vehicles face, from the side of the road that they stand on."""

import re
from collections.abc import Sequence

from roadmend.safe.dsl import Position, Side
from roadmend.safe.reading.clauses import Clause
from roadmend.safe.reading.directions import Headings, turned
from roadmend.safe.reading.finding import Finding

_PARKED = re.compile(r"\b(?:parked|unattended|unoccupied)\b")
_ONE_WAY = re.compile(r"\b(?:1|one)-?\s?way\b")
_WRONG_WAY = re.compile(r"\bwrong[- ](?:way|direction)\b")
_EDGE = r"(?:(?:road|roadway|street|lane|outside|outer|paved|curb) )*(?:side|edge|shoulder|curb|roadside|berm)"
_ALONG = re.compile(rf"\b(?:(north|south|east|west)|(left|right))(?:ern)?(?: hand)? {_EDGE}\b")
# Where traffic keeps to the right, those who head west have the north edge beside them.
_ALONG_EDGE = {"north": Position.E2W, "south": Position.W2E, "east": Position.S2N, "west": Position.N2S}
_EDGES = {
    Position.W2E: {"north", "south"},
    Position.E2W: {"north", "south"},
    Position.S2N: {"east", "west"},
    Position.N2S: {"east", "west"},
}


def park_headings(headings: Headings, clauses: Sequence[Clause]) -> dict[int, Finding[Position]]:
    """Fill the heading of a parked vehicle from that of the one that travels along the road."""
    found = dict(headings)
    moving = [finding.value for finding in headings.values() if finding.value is not None]
    if not moving:
        return found
    along = moving[0]
    text = " ".join(clause.text for clause in clauses)
    one_way = bool(_ONE_WAY.search(text)) and not _WRONG_WAY.search(text)
    for clause in clauses:
        if not _PARKED.search(clause.text):
            continue
        for number in _of_whom(clause, headings):
            position = along if one_way else _beside(clause.text, along)
            if position is not None and found[number].value is None:
                found[number] = Finding(position, 0.5, clause.sentence, "the side of the road it is parked on")
    return found


def _of_whom(clause: Clause, headings: Headings) -> list[int]:
    named = {*clause.subjects, *(int(number) for number in re.findall(r"\bv(\d)\b", clause.text))}
    return sorted(number for number in named if number in headings and headings[number].value is None)


def _beside(text: str, along: Position) -> Position | None:
    match = _ALONG.search(text, max(text.find("parked"), 0))
    if match is None:
        return None
    if match[1]:
        return _ALONG_EDGE[match[1]] if match[1] in _EDGES[along] else None
    return along if match[2] == "right" else turned(turned(along, Side.LEFT), Side.LEFT)
