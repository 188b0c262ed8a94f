"""Directions of travel before the crash."""

import re
from collections.abc import Mapping, Sequence

from roadmend.safe.compass import BOUND, opposite, turned
from roadmend.safe.dsl import Position, Side
from roadmend.safe.reading.clauses import Clause
from roadmend.safe.reading.text import Finding, nothing

_COMPASS = r"(north|south|east|west)"
_PLACE = (
    r"(?:side|(?:\w+ )?edge|corner|shoulder|curb|leg|roadside|ditch|road edge|end|portion|half|of\b|roadway edge|"
    r"bank|sidewalk|parking|fork|lot)"
)
# Text that has a compass word in it and says nothing about where the vehicle came from.
_MISLEADING = tuple(
    re.compile(pattern)
    for pattern in (
        r"\b(?:north|south|east|west)(?:bound)?\s*(?:/|-|and|or|to)\s*(?:north|south|east|west)(?:bound)?\b(?! to)",
        rf"\b{_COMPASS}(?:bound)? {_PLACE}",
        rf"\bby v\d\)?, {_COMPASS}bound",
        (
            r"\b(?:into|onto|entered|entering|enters|enter|re-?enter\w*|across|cross(?:ed|ing|es)?|over|toward|"
            r"towards)\s+(?:into |across |onto |over )?(?:the |both |all |all of the )?(?:opposing |opposite |"
            r"oncoming |adjacent |intersecting |path of (?:the )?|\d+ |first |second |third |inside |outside |"
            r"left |right |center |near |far )*(?:north|south|east|west)bound (?:\w+ ){0,3}?(?:lanes?|traffic|"
            r"roadway|shoulder)\b"
        ),
        r"\b(?:opposing|oncoming|opposite|adjacent|several|other|all)\s+(?:north|south|east|west)bound\b",
        rf"\b(?:in|on|at) the {_COMPASS}bound (?:shoulder|roadside|ditch|on-ramp|curb)",
        r"\b(?:pushed|pushing|redirected|spun|rolled|knocked|thrown|rotat\w+|deflected)\b[^,;]*",
        (
            r"\b(?:came|coming|come|comes) to (?:a |its )?(?:final |complete )*(?:rest|"
            r"stop)\b.*?(?=, (?:and|when|where)|$)"
        ),
        r"\b(?:final )?rest(?:ing|ed)?\b.*",
    )
)
_ON_LANE = re.compile(rf"\bin (?:the |a )?(?:[\w-]+ ){{0,4}}?{_COMPASS}bound\b")
_INTENT = re.compile(
    r"\b(?:inten\w+|attempt\w*|in order to|so as to|want\w*|plan\w*|prepar\w*|waiting|wait|to turn|"
    r"turn(?:ed|ing|s)?\b|about to|(?:before|after) (?:making|turning)|made? a|making a|continu\w+|would|"
    r"proceeded to|began to|going to)\b.*"
)
_FROM = re.compile(
    rf"\b(?:from|out of) the {_COMPASS}\b(?! (?:side|leg|lane|bound|to\b))|"
    rf"\bfrom (?:the )?{_COMPASS}(?:bound)? to(?:ward)?s? (?:the )?{_COMPASS}|"
    rf"\b{_COMPASS}(?:bound)? to {_COMPASS}(?:bound)?\b|\bfrom {_COMPASS}bound (?!(?:\w+ )?(?:lanes?|traffic)\b)|"
    rf"\bturn\w* (?:left|right) from the {_COMPASS}bound\b"
)
_TOKEN = re.compile(
    rf"(?<![\w/-]){_COMPASS}(?:bound|erly)?\b(?![/-]| (?:and|or) (?:north|south|east|west)|(?:east|west))"
)
_HEADING_AFTER = re.compile(
    r"\b(?:to|and|onto|then)?\s*(?:travel|head|go|proceed|continue|drive|traveling|heading|going|proceeding|"
    rf"continuing)?\w*\s*(?:onto (?:the )?|to (?:the )?|on (?:the )?)?\(?{_COMPASS}(?:bound)?\b"
)

_SAME = re.compile(
    r"\b(?:also|in the same direction|same (?:travel )?(?:lane|direction|travel|way)|behind|following|ahead of|"
    r"in front of|trailing|passing|overtak\w+|rear-ended)\b"
)
_TURN_LANE = re.compile(r"\b(?:(?:left|right|center|2-way|only)[- ])*turn(?:ing)?(?:[- ]only)?[- ]lanes?\b")
# "a southbound 2006 Ford (v2)"
_ADJECTIVE = re.compile(
    rf"\b{_COMPASS}bound (?:(?!(?:lanes?|roadway|road|traffic|shoulder|direction|travel|side|street|highway|v\d|"
    rf"and|when|where|was|by|at)\b)[\w/-]+,? ){{0,7}}\(?v(\d)\b|\bv(\d)\)?,? an? {_COMPASS}bound\b|"
    rf"\bby v(\d)\)?, {_COMPASS}bound\b"
)
_NEAR = r"\b(?:ahead of|behind|following|in front of|pass|passing|overtak\w+|trailing) (?:[^.;,]{0,60}\()?(?:\w+ )?"
_INTO_THE_WAY = re.compile(r"\b(?:turn\w*|cross\w*|pull\w* out)\b[^,;.]{0,40}?\bin front of\b")
_NOT_OWN = re.compile(r"\b(?:(?:came|coming|come) to (?:a )?(?:final )?rest|rotat\w+|rebounded|spun)\b")
_OPPOSING = re.compile(
    r"\b(?:in the )?(?:opposite|opposing|oncoming)(?: travel)?(?: direction|\b)|\bfrom the opposite\b|"
    r"\b(?:the )?other (?:way|direction)\b|\bhead-?on\b"
)
_INTO_ONCOMING = re.compile(
    rf"\b(?:cross|drift|veer|swerv|slid)\w*\b[^.;,]{{0,40}}?\b(?:in|on)to (?:the )?{_COMPASS}bound (?:\w+ )?lanes?\b"
)
_REFERENCE = re.compile(r"\bv(\d)\b")

Headings = Mapping[int, Finding[Position]]


def read_headings(clauses: Sequence[Clause], numbers: Sequence[int]) -> dict[int, Finding[Position]]:
    """The direction of travel of each vehicle, as far as the report says it of that vehicle."""
    found: dict[int, Finding[Position]] = {}
    for clause in clauses:
        for match in _ADJECTIVE.finditer(clause.text):
            compass = match[1] or match[4] or match[6]
            number = int(match[2] or match[3] or match[5])
            if number in numbers and not _is_aftermath(clause.text):
                found.setdefault(number, Finding(BOUND[compass], 0.9, clause.sentence, "the word before its name"))
    for read, confidence, reason in (
        (_stated, 0.95, "said of this vehicle"),
        (_from_where, 0.85, "where it came from"),
        (_lane, 0.85, "the lane it was in"),
        (_intended, 0.7, "where it was going to, with no turn before"),
    ):
        for clause in clauses:
            for number in clause.subjects:
                if number in found or _is_aftermath(clause.text):
                    continue
                position = read(clause.text)
                if position is not None:
                    found[number] = Finding(position, confidence, clause.sentence, reason)
    return {number: found.get(number) or nothing("no direction of travel is stated") for number in numbers}


_PLACE_OF_CRASH = re.compile(
    r"\b(?:crash|collision|accident|incident|impact) (?:[^.;]{0,40} )?(?:occurred|happened|took place|"
    rf"occurs)\b[^.]*\b(?:in|on|along) (?:the|an?) (?:[\w-]+ ){{0,4}}?{_COMPASS}bound\b"
)


def heading_of_the_place(clauses: Sequence[Clause]) -> Finding[Position]:
    """The direction of the lanes in which the crash happened, where that is one."""
    for clause in clauses:
        match = _PLACE_OF_CRASH.search(clause.text)
        if match:
            return Finding(BOUND[match[1]], 0.6, clause.sentence, "the lanes in which the crash happened")
    return nothing("the place of the crash names no direction")


def relate_headings(
    headings: Headings,
    clauses: Sequence[Clause],
    turns: Mapping[int, Side | None],
    contacts: Sequence[tuple[int, int, str]],
) -> dict[int, Finding[Position]]:
    """Fill what is open from how the vehicles stand to each other, from turns, and from what hit what.

    Args:
        headings: those stated.
        clauses: of the report.
        turns: the side to which each vehicle turns, None for straight on.
        contacts: pairs (striking, struck, "front-rear" for instance) in order.
    """
    found = dict(headings)
    for _ in range(2):  # what one step finds may help the next
        for number in [number for number, finding in found.items() if finding.value is None]:
            for step in (_relative, _before_the_turn, _over_the_line):
                finding = step(number, found, clauses, turns)
                if finding is not None:
                    found[number] = finding
                    break
        for first, second, sides in contacts:
            for one, other in ((first, second), (second, first)):
                known, open_one = found.get(one), found.get(other)
                if known is None or open_one is None or known.value is None or open_one.value is not None:
                    continue
                if sides in {"front-rear", "-rear"} and turns.get(one) is None and turns.get(other) is None:
                    found[other] = Finding(known.value, 0.7, known.sentence, f"hit from behind, so it headed as v{one}")
                elif sides == "front-front" and not turns.get(one) and not turns.get(other):
                    found[other] = Finding(
                        opposite(known.value), 0.6, known.sentence, f"head-on, so it came towards v{one}"
                    )
    return found


def _is_aftermath(text: str) -> bool:
    return bool(
        re.match(r"(?:after|following) (?:the |this )?(?:initial |first )?(?:impact|collision|contact|crash)", text)
    )


def _masked(text: str) -> str:
    for pattern in _MISLEADING:
        text = pattern.sub(" ", text)
    return text


def _stated(text: str) -> Position | None:
    text = _TURN_LANE.sub(" lane", text)
    if _FROM.search(text):
        return None
    own = _NOT_OWN.split(_INTENT.sub(" ", _masked(text)))[0]
    match = _TOKEN.search(own)
    return BOUND[match[1]] if match else None


def _from_where(text: str) -> Position | None:
    match = _FROM.search(_NOT_OWN.split(text)[0])
    if match is None:
        return None
    coming, _, to_first, _, to_second, road, lane = match.groups()
    if coming:
        return opposite(BOUND[coming])
    return BOUND[to_first or to_second or road or lane]


def _lane(text: str) -> Position | None:
    match = _ON_LANE.search(_NOT_OWN.split(text)[0])
    return BOUND[match[1]] if match else None


def _intended(text: str) -> Position | None:
    if re.search(r"\b(?:turn\w*|u-turn|struck|impact\w*|hit)\b", text) or not re.search(
        r"\b(?:continu\w+|straight|inten\w+|attempt\w*)\b", text
    ):
        return None
    match = _TOKEN.search(_masked(text))
    return BOUND[match[1]] if match else None


def _relative(
    number: int, found: Headings, clauses: Sequence[Clause], turns: Mapping[int, Side | None]
) -> Finding[Position] | None:
    del turns
    for clause in clauses:
        if re.search(r"\b(?:rotat|rest\b)", clause.text):
            continue
        if number not in clause.subjects:
            behind = re.search(rf"{_NEAR}v{number}\b", _INTO_THE_WAY.sub(" ", clause.text))
            leader = found.get(clause.subjects[0]) if behind and len(clause.subjects) == 1 else None
            if leader is not None and leader.value is not None:
                return Finding(leader.value, 0.75, clause.sentence, f"as v{clause.subjects[0]}")
            continue
        others = [int(other) for other in _REFERENCE.findall(clause.text) if int(other) != number]
        others += [other for other in found if other != number and not others]
        for other in others:
            known = found.get(other)
            if known is None or known.value is None:
                continue
            if (
                _OPPOSING.search(clause.text)
                and re.search(r"direction|oncoming v|opposite|opposing|other way", clause.text)
                and re.search(r"travel|approach|from|head|com", clause.text)
            ):
                return Finding(opposite(known.value), 0.75, clause.sentence, f"opposite to v{other}")
            text = _INTO_THE_WAY.sub(" ", clause.text)
            if _SAME.search(text) and re.search(rf"{_NEAR}v{other}\b|same|also", text):
                return Finding(known.value, 0.75, clause.sentence, f"as v{other}")
    return None


def _before_the_turn(
    number: int, found: Headings, clauses: Sequence[Clause], turns: Mapping[int, Side | None]
) -> Finding[Position] | None:
    del found
    side = turns.get(number)
    if side is None:
        return None
    back = Side.RIGHT if side is Side.LEFT else Side.LEFT
    for clause in clauses:
        turn = re.search(r"\bturn\w*\b(.{0,80})", clause.text)
        if number in clause.subjects and turn:
            match = _HEADING_AFTER.search(_NOT_OWN.split(turn[1])[0])
            if match:
                return Finding(
                    turned(BOUND[match[1]], back), 0.65, clause.sentence, "the way it turned to, turned back"
                )
    return None


def _over_the_line(
    number: int, found: Headings, clauses: Sequence[Clause], turns: Mapping[int, Side | None]
) -> Finding[Position] | None:
    del found
    if turns.get(number) is not None:
        return None
    for clause in clauses:
        match = _INTO_ONCOMING.search(clause.text)
        if match and clause.subjects == (number,):
            return Finding(opposite(BOUND[match[1]]), 0.6, clause.sentence, "it came into the lane of the other way")
    return None
