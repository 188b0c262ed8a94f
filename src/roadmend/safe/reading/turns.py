"""What each vehicle does: turns, and the manoeuvres that the paper's grammar calls Move Forward."""

import re
from collections.abc import Mapping, Sequence

from roadmend.safe.compass import BOUND, opposite, turned
from roadmend.safe.dsl import Manoeuvre, Position, Side
from roadmend.safe.reading.clauses import Clause
from roadmend.safe.reading.directions import Headings
from roadmend.safe.reading.text import Finding, nothing

_SIDE = r"(left|right)"
# "left turn lane" is a place, "turn the wheel left" steering, "left-turning curve" a bend
_NO_TURN = re.compile(
    rf"\b{_SIDE}[- ]?turn(?:ing)?(?:[- ]only)?[- ](?:lanes?|bay|pocket|arrow|signal|curve)|"
    rf"\bturn(?:ing)? (?:only )?lanes?\b|\b{_SIDE}[- ]turn(?:ing)? (?:and|or) \w+ lanes?|"
    r"\bturn(?:ed|ing)? (?:the|his|her|its|their) (?:\w+ ){0,2}?(?:steering|wheel|handle\w*|head|signals?)\b|"
    rf"\b(?:quarter|half|full)[- ]turns?\b|\b{_SIDE} turn only\b|\bcurv\w+(?: to the)? {_SIDE}\b|"
    rf"\b{_SIDE}[- ]turning\b(?= (?:vehicles?|lane|traffic|curve))|\bpath of (?:a |the )?turning|"
    rf"\bturn(?:ed|ing)? (?:onto|on) (?:its|his|her|their) (?:side|roof|top|{_SIDE} side)|\bno {_SIDE} turns?\b"
)
_TURN = re.compile(
    r"\bturn(?:ed|ing|s)?(?:\s+(?:back|sharply|abruptly|suddenly|wide|quickly))?\s+(?:to (?:the |its |his |her )?|"
    rf"toward (?:the )?)?{_SIDE}\b(?! (?:lane|side))|\b{_SIDE}(?:-hand)?[- ]turn(?:s|ing)?\b|"
    r"\b(?:make|made|making|makes|executing|execute[ds]?|initiat\w+|negotiat\w+|perform\w*|begin|began|beginning|"
    r"complet\w+|start\w*)(?: to make)? (?:an? |its |his |her |"
    rf"the )?(?:\w+ )?{_SIDE}\b(?! (?:curve|lane|bend|side))|"
    rf"\b(?:go|going|went)\s+{_SIDE}\b(?= (?:at|on|onto|into))|\bhung? a {_SIDE}\b"
)
_U_TURN = re.compile(r"\bu-?\s?turn")
_OTHER_TURNS = re.compile(
    r"\b(?:(?:non-?contact|another|other|unknown|phantom|an?|several|lead|preceding) (?:\w+ )?(?:vehicles?|cars?|"
    r"trucks?|motorists?)|the (?:vehicle|car|traffic|truck) (?:\w+ )?(?:in front|ahead)|traffic|vehicles? in front|"
    r"(?:allow|for|waiting for|wait for|yield\w* to|let) (?:a |an |the |another |several )?(?:\w+ ){0,2}(?:vehicle|"
    r"car|v\d|traffic)s?)\b"
)
_CLEARS = re.compile(r"\b(?:wait\w*|allow\w*|yield\w*)\b[^,;]{0,60}?\b(?:clear|pass|go by)\b")
_NOT = re.compile(r"\b(?:no|not|never|without|instead of|rather than)\s+(?:\w+ ){0,2}$")
_AFTER = re.compile(r"^(?:after|following) (?:the |this )?(?:initial |first )?(?:impact|collision|contact|crash|event)")
_LANE = re.compile(
    r"\b(?:travel\w*|stopped|driv\w+|head\w*|position\w*|waiting|was|northbound|southbound|eastbound|westbound|"
    r"east|west|north|south|turning)\b(?:(?! lane\b| "
    rf"of\b)[^,;.]){{0,50}}\b{_SIDE}[- ]turn(?:ing)?(?:[- ]only)?[- ]lane"
)
_STRAIGHT = re.compile(
    r"\b(?:go|going|proceed\w*|continu\w+|travel\w*|driv\w+|pass\w*|cross\w*) (?:straight|through|over)|"
    r"\bstraight (?:through|ahead|across|on)|\bcross(?:ing)?(?:-| )?(?:over )?(?:through )?the intersection|"
    r"\bcontinue (?:traveling |driving |heading )?(?:north|south|east|west)"
)

_MANOEUVRES = (
    (
        Manoeuvre.MERGE,
        re.compile(
            r"\b(?:merg(?:e|ed|ing)\b|(?:entering|enter|entered) (?:the |"
            r"onto the )?(?:same )?(?:freeway|highway|interstate|expressway)|"
            r"acceleration lane)"
        ),
    ),
    (
        Manoeuvre.ENTER_THE_WRONG_WAY,
        re.compile(
            r"\b(?:cross\w*|drift\w*|travel\w*|veer\w*|steer\w*|swerv\w*|mov\w+|enter\w*|encroach\w*|went|slid|"
            r"skid\w*|left|over|departed)\b[^.;]{0,60}?\b(?:centerline|center line|center of the road|median|"
            r"double yellow|opposing|oncoming|opposite (?:lane|side)|wrong (?:way|side)|"
            r"into v\d's (?:travel )?lane|center lane lines?|left of center)|\bwrong[- ]way\b|"
            r"\bhead-on\b.*\blane of v|left of center"
        ),
    ),
    (
        Manoeuvre.CHANGING_LANE,
        re.compile(
            r"\b(?:chang\w+ lanes?|lane[- ]chang\w*|(?:veer|mov|steer|swerv|drift|cross|merg|cut|encroach|"
            r"enter)\w*\b[^.;]{0,50}\b(?:into|over) (?:the |another |an )?(?:adjacent |\d+ |first |second |third |"
            r"fourth |number \d |next |inside |outside )?(?:left|right|center|middle|adjacent|next|passing|inside|"
            r"outside|second|third|first|number)? ?(?:(?:north|south|east|west)bound |travel |through )*lane)"
        ),
    ),
    (
        Manoeuvre.STOP,
        re.compile(
            r"\b(?:was|were|is|been|sat|and|which|that)\s+(?:\w+ ){0,2}(?:stopped|parked|"
            r"stationary|at a (?:complete )?stop|disabled|stalled)\b|"
            r"\b(?:came|brought[^.;]{0,20}) to a stop\b|^v\d (?:had )?stopped\b"
        ),
    ),
)

_INTO_LANE = re.compile(
    r"\b(?:enter\w*|into|across|cross\w*|onto|over)\b[^.;]{0,30}?\b(north|south|east|"
    r"west)bound\b(?! (?:shoulder|roadside|curb))"
)


def read_turns(clauses: Sequence[Clause], numbers: Sequence[int]) -> dict[int, Finding[Side]]:
    """The side to which each vehicle turns; no value where it does not, with a confidence that it goes straight on."""
    found: dict[int, Finding[Side]] = {}
    straight: dict[int, Finding[Side]] = {}
    for clause in clauses:
        if len(clause.subjects) != 1 or _AFTER.search(clause.text):
            continue
        number = clause.subjects[0]
        side = _turn_in(clause.text)
        if side is not None and number not in found:
            found[number] = Finding(side, 0.9, clause.sentence, "the turn is stated")
        elif _STRAIGHT.search(clause.text) and number not in straight and side is None:
            straight[number] = Finding(None, 0.9, clause.sentence, "it goes straight on")
    for clause in clauses:
        for number in clause.subjects:
            lane = _LANE.search(clause.text)
            if lane and number not in found and number not in straight:
                found[number] = Finding(Side(lane[1].title()), 0.6, clause.sentence, "it is in a lane for turning")
    return {number: found.get(number) or straight.get(number) or nothing("no turn is mentioned") for number in numbers}


def _turn_in(text: str) -> Side | None:
    plain = _NO_TURN.sub(" ", text)
    for match in _TURN.finditer(plain):
        before = plain[: match.start()]
        if _NOT.search(before) or _OTHER_TURNS.search(_CLEARS.sub(" ", before)):
            continue
        side = next(filter(None, match.groups()))
        return Side(side.title())
    return Side.LEFT if _U_TURN.search(plain) and not _OTHER_TURNS.search(plain) else None


def read_manoeuvres(
    clauses: Sequence[Clause], turns: Mapping[int, Finding[Side]], headings: Mapping[int, Finding[Position]]
) -> dict[int, Finding[Manoeuvre]]:
    """What each vehicle does in more words than the grammar's actions have."""
    found: dict[int, Finding[Manoeuvre]] = {}
    for number in turns:
        side = turns[number].value
        if side is not None:
            named = Manoeuvre.TURN_LEFT if side is Side.LEFT else Manoeuvre.TURN_RIGHT
            found[number] = Finding(named, turns[number].confidence, turns[number].sentence, turns[number].reason)
            continue
        own = [clause for clause in clauses if clause.subjects == (number,) and not _AFTER.search(clause.text)]
        for clause in own:
            before_rest = re.split(
                r"\b(?:rotat|(?:came|coming|come) to (?:a )?(?:final )?rest|struck by|was struck)", clause.text
            )[0]
            lane = _INTO_LANE.search(before_rest)
            if lane and opposite(BOUND[lane[1]]) is headings[number].value:
                found[number] = Finding(
                    Manoeuvre.ENTER_THE_WRONG_WAY, 0.85, clause.sentence, "it enters the other direction"
                )
                break
            kind = next((kind for kind, pattern in _MANOEUVRES if pattern.search(before_rest)), None)
            if kind is not None:
                found[number] = Finding(kind, 0.75, clause.sentence, "the words for it")
                break
        else:
            found[number] = Finding(Manoeuvre.MOVE_FORWARD, 0.6, None, "nothing else is mentioned")
    return found


_PARKED = re.compile(r"\b(?:parked|unattended|unoccupied)\b")
_ONE_WAY = re.compile(r"\b(?:1|one)-?\s?way\b")
_WRONG_WAY = re.compile(r"\bwrong[- ](?:way|direction)\b")
_EDGE = r"(?:(?:road|roadway|street|lane|outside|outer|paved|curb) )*(?:side|edge|shoulder|curb|roadside|berm)"
_ALONG = re.compile(rf"\b(?:(north|south|east|west)|(left|right))(?:ern)?(?: hand)? {_EDGE}\b")


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
        # Where traffic keeps to the right, those who head west have the north edge beside them.
        beside = turned(BOUND[match[1]], Side.LEFT)
        return beside if beside in {along, opposite(along)} else None
    return along if match[2] == "right" else opposite(along)
