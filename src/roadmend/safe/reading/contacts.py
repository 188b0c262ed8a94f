"""Who hit whom, and with which sides."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from roadmend.safe.compass import opposite, turned
from roadmend.safe.dsl import Position, Side
from roadmend.safe.reading.clauses import Clause
from roadmend.safe.reading.directions import Headings
from roadmend.safe.reading.text import Finding

_SIDES = (
    (Side.LEFT, r"left|driver'?s?[- ]side"),
    (Side.RIGHT, r"right|passenger'?s?[- ]side"),
    (Side.FRONT, r"front(?:al)?|head-?on|nose"),
    (Side.REAR, r"rear|back|tail|trailer"),
)
_CORNER = re.compile(
    r"\b(?:left|right)[- ](front|rear)(?:al)?\b(?! (?:door|quarter|fender))|\b(front|rear)[- ](?:left|right)\b"
)
_HIT = re.compile(
    r"\b(?:(?P<into>struck|hit|impacted|contacted|collided with|made contact with|ran into|crashed into|rear-ended|"
    r"sideswiped|t-boned|broadsided|rammed|slammed into|clipped|strikes|hits|impacts|contacts|collides with|"
    r"rear-ends)|(?P<to>(?<=to )(?:strike|hit|impact|contact|collide with|rear-end)|striking|hitting|impacting|"
    r"contacting|colliding with|rear-ending|sideswiping|crashing into))\b"
)
_PASSIVE = re.compile(r"\b(?:was|were|being|got|is|been)\s+(?:\w+ly\s+|then\s+|also\s+|subsequently\s+)?$")
_REFERENCE = re.compile(r"\bv(\d)\b")
_APPOSED = re.compile(r"(?<=\bv\d), (?:an?|the) [^,;]{2,60},")
_WITH = re.compile(r"\bwith (?:the |its |his |her )?(.{0,60})")
_TOGETHER = re.compile(
    r"\bv(\d) and v(\d)\b[^;.]{0,30}\b(?:collided|impacted|struck each|hit each|made contact)\b(?P<how>[^.;]{0,60})"
)
_TOLD = re.compile(r"\b(?:stated|said|reported) (?:that )?(?:he|she)")
_FRONT_OF_NECESSITY = re.compile(r"rear-end|t-boned|broadsided")


@dataclass(frozen=True, slots=True)
class ContactStatement:
    """Two vehicles touch.

    Attributes:
        striking: number of the one that runs into the other.
        struck: the other one's.
        striking_side: None where it is not said.
        struck_side: None where it is not said.
        sentence: that says so, as the report puts it.
    """

    striking: int
    struck: int
    striking_side: Side | None
    struck_side: Side | None
    sentence: str

    @property
    def sides(self) -> str:
        """For instance "front-rear"."""
        return f"{self.striking_side or ''}-{self.struck_side or ''}".lower()


def read_contacts(clauses: Sequence[Clause], numbers: Sequence[int]) -> tuple[ContactStatement, ...]:
    """The contacts between vehicles in the order of the report, each pair of vehicles once."""
    contacts: dict[frozenset[int], ContactStatement] = {}
    for clause in clauses:
        if _TOLD.search(clause.text):
            continue
        for contact in (*_hits(clause), *_together(clause)):
            pair = frozenset((contact.striking, contact.struck))
            if len(pair) == 2 and pair <= set(numbers):
                known = contacts.get(pair)
                if known is None or (known.struck_side is None and contact.struck_side is not None):
                    contacts[pair] = contact
    return tuple(contacts.values())


def _hits(clause: Clause) -> list[ContactStatement]:
    contacts = []
    for verb in _HIT.finditer(clause.text):
        before, after = clause.text[: verb.start()], clause.text[verb.end() :]
        after = _HIT.split(after)[0]
        earlier, later = list(_REFERENCE.finditer(before)), list(_REFERENCE.finditer(after))
        one = int(earlier[-1][1]) if earlier else clause.subjects[0] if len(clause.subjects) == 1 else None
        # The side is named in the last phrase before the verb: "the front of v2".
        phrases = re.split(r",|\band the\b|\bwhen\b|\bv\d (?=and)", _APPOSED.sub(" ", before))
        near = phrases[-1] if earlier else before[-60:]
        if _PASSIVE.search(before):
            by = after.find("by ")
            by_whom = [match for match in later if match.start() > by >= 0]
            if one is None or not by_whom:
                continue
            striking = int(by_whom[0][1])
            on = _side(after[:by]) or _side(near)
            contacts.append(ContactStatement(striking, one, _side(after[by:]), on, clause.sentence))
        elif later:
            struck = int(later[0][1])
            with_what = _WITH.search(after)
            if verb["to"] and with_what and (named := _REFERENCE.search(with_what[1])):
                one = int(named[1])
            elif verb["to"] and not re.search(r"of v\d to $", before) and clause.subjects:
                one = clause.subjects[0]
            if one is None:
                continue
            where = after[: with_what.start()] if with_what else after
            struck_side = _side(where) or (Side.REAR if verb[0].startswith("rear-end") else None)
            striking_side = _side(with_what[1]) if with_what else None
            if striking_side is None and (_FRONT_OF_NECESSITY.search(verb[0])):
                striking_side = Side.FRONT
            contacts.append(ContactStatement(one, struck, striking_side or _side(near), struck_side, clause.sentence))
    return contacts


def _together(clause: Clause) -> list[ContactStatement]:
    match = _TOGETHER.search(clause.text)
    if match is None:
        return []
    side = Side.FRONT if "head" in match["how"] or "front" in match["how"] else None
    return [ContactStatement(int(match[1]), int(match[2]), side, side, clause.sentence)]


def _side(text: str) -> Side | None:
    corner = _CORNER.search(text)
    if corner:
        return Side((corner[1] or corner[2]).title())
    places = [(match.start(), side) for side, words in _SIDES if (match := re.search(rf"\b(?:{words})\b", text))]
    return min(places)[1] if places else None


Turns = Mapping[int, Side | None]


def cross_headings(headings: Headings, turns: Turns, first: ContactStatement) -> dict[int, Finding[Position]]:
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
        return opposite(heading)
    return turned(heading, Side.RIGHT if side is Side.LEFT else Side.LEFT)


def _came_from(known: int, other: int, turns: Turns, contact: ContactStatement) -> Side | None:
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
