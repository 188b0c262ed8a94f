"""Directions of travel that follow from the sides with which two vehicles met at a junction."""

from collections.abc import Mapping

from roadmend.safe.dsl import Position, Side
from roadmend.safe.reading.contacts import Contact
from roadmend.safe.reading.directions import Headings, turned
from roadmend.safe.reading.finding import Finding

Turns = Mapping[int, Side | None]


def cross_headings(headings: Headings, turns: Turns, first: Contact) -> dict[int, Finding[Position]]:
    """Fill the heading of one of two vehicles from the other's.

    Args:
        headings: as far as they are known.
        turns: the side to which each vehicle turns, None for straight on.
        first: the first contact; after it the vehicles may have been turned about.
    """
    found = dict(headings)
    for known, other in ((first.striking, first.struck), (first.struck, first.striking)):
        heading = headings[known].value
        if heading is None or headings[other].value is not None:
            continue
        side = _came_from(known, other, turns, first)
        if side is not None:
            reason = f"by the sides that met it came from the {side.lower()} of v{known}"
            found[other] = Finding(_heading_from(side, heading), 0.5, first.sentence, reason)
    return found


def _heading_from(side: Side, heading: Position) -> Position:
    if side is Side.FRONT:
        return turned(turned(heading, Side.LEFT), Side.LEFT)
    return turned(heading, Side.RIGHT if side is Side.LEFT else Side.LEFT)


def _came_from(known: int, other: int, turns: Turns, contact: Contact) -> Side | None:
    """The side of the known vehicle from which the other came; None where the contact leaves it open."""
    if contact.striking_side is not Side.FRONT:
        return None
    struck_turn = turns.get(contact.struck)
    if contact.struck_side is Side.FRONT:
        # Who turns left meets those who come towards it; who turns right joins those who come from its left.
        if Side.LEFT in {turns.get(known), turns.get(other)}:
            return Side.FRONT
        if turns.get(known) is Side.RIGHT:
            return Side.LEFT
        return Side.RIGHT if turns.get(other) is Side.RIGHT else None
    if contact.struck_side is Side.RIGHT and struck_turn is Side.LEFT:
        return Side.FRONT
    if contact.struck_side is Side.LEFT:
        return Side.LEFT if known == contact.struck else Side.RIGHT
    if contact.struck_side is Side.RIGHT and struck_turn is None:
        return Side.RIGHT if known == contact.struck else Side.LEFT
    return None
