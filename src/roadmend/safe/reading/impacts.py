"""What a vehicle strikes that is no vehicle, with which side, and on which side of its road that stands."""

import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Compass, Side, StruckObject
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, of_vehicle
from roadmend.safe.reading.lexicon import read_table, squeeze
from roadmend.safe.reading.tokens import Item, Words

STRUCK, STRUCK_WITH, ROADSIDE = "struck", "struck_with", "roadside"  # fields of a vehicle in the claims made here
_NEAR = 10  # words after the verb that name what is struck
_INTO = frozenset({"into", "against", "through"})
_BEFOREHAND = frozenset({"case", "investigation", "focused", "involves", "involved"})  # of a sentence that sums up
_LED = 5  # words after such a preposition
_HAND = 3  # words after "with" that name a side
_SURE, _TOLD, _BEFORE = 0.9, 0.6, 0.7
_MOVES = frozenset({"travel", "depart", "drift", "continue", "turn", "change_lane", "emerge"})
_GOES = _MOVES | {"approach", "stop", "slow"}
_SIDE = r"(?<!['\u2019])(?P<side>left|right|north|south|east|west|[nsew](?= side| edge| shoulder))(?:ern)?(?:[- ]hand)?"
_ROAD = r"(?:road(?:way)?|highway|street|interstate|freeway|lanes?|trafficway|pavement)"
_EDGES = rf"(?:road ?side|road edge|shoulder|verge|curb|kerb|ditch|embankment|(?:side|edge) of (?:the |its )?(?:\w+ )?{_ROAD})"
_LEAVE = r"(?:off|depart\w*|leaves?|left|leaving|exit\w*)"
_NO_SIDE = r"(?! lane| side| front| rear| of (?!the road))"
_PLACES = (
    rf"\b{_SIDE} (?:\(\w+\) )?{_EDGES}",
    rf"\b{_LEAVE} (?:\w+ ){{0,3}}?{_ROAD},? (?:(?:edge )?(?:to|on|onto|at) (?:the |its )?)?{_SIDE}\b{_NO_SIDE}",
    rf"\b(?:depart\w*|left) (?:\w+ ){{0,2}}?(?:on )?(?:the |its )?{_SIDE} (?:side|edge)\b(?! of the (?:car|veh))",
    rf"\b(?:r[au]n|went|veer\w*|drift\w*|slid|swerv\w*|travel\w*|go\w*) off (?:to )?(?:the |its )?{_SIDE}\b(?! lane)",
)
_PLACE = tuple(re.compile(each, re.IGNORECASE) for each in _PLACES)


_POINTS = {"n": "north", "s": "south", "e": "east", "w": "west"}


@dataclass(frozen=True, slots=True)
class _Impact:
    vehicle: int
    object: StruckObject
    side: Side | None
    where: Span
    confidence: float


def read_impacts(text: Text) -> Iterator[Claim]:
    """The claims of a text about the first impact of each vehicle with what is none."""
    found: dict[int, _Impact] = {}
    for impact in sorted(
        _impacts(text), key=lambda each: each.confidence <= _TOLD
    ):  # what is told beforehand comes last
        found.setdefault(impact.vehicle, impact)
    for impact in found.values():
        reason = "the text says that it was struck"
        yield claim(of_vehicle(impact.vehicle, STRUCK), impact.object, impact.confidence, reason, impact.where)
        if impact.side is not None:
            yield claim(of_vehicle(impact.vehicle, STRUCK_WITH), impact.side, impact.confidence, reason, impact.where)
        place = _roadside(text, impact)
        if place is not None:
            word, span = place
            value = Side(word.title()) if word in {"left", "right"} else Compass(_POINTS.get(word, word).title())
            reason = "the text says where it left its road, or where that stood"
            yield claim(of_vehicle(impact.vehicle, ROADSIDE), value, _SURE, reason, span)


def _impacts(text: Text) -> Iterator[_Impact]:
    before: StruckObject | None = None  # the last thing that was spoken of
    for clause in text.clauses:
        things = [(item, thing) for item in (*clause.head, *clause.tail) if (thing := _thing(item)) is not None]
        struck = _struck(clause, before)
        if struck is not None and clause.is_real and len(clause.subject.vehicles) == 1:
            thing, span, sure = struck
            yield _Impact(clause.subject.vehicles[0], thing, _with(clause), span, sure)
        before = things[-1][1] if things else before


def _struck(clause: Clause, before: StruckObject | None) -> tuple[StruckObject, Span, float] | None:
    """What a clause says to be struck, where it says so, and how surely."""
    named = _first(clause.tail.cut(0, _NEAR))
    if clause.kind in STRIKES:
        if named is not None and not clause.is_passive:
            return *named, _TOLD if any(item.low in _BEFOREHAND for item in clause.sentence.items) else _SURE
        is_it = clause.is_passive or any(not actor.vehicles for _, actor in clause.others)
        if before is not None and clause.lemma != "back" and is_it:  # "it was struck", "the edge of the trailer"
            return before, clause.span, _BEFORE
        return None
    if clause.kind in _MOVES:
        for place, item in enumerate(clause.tail):
            led = _first(clause.tail.cut(place + 1, place + 1 + _LED)) if item.low in _INTO else None
            if led is not None:
                return *led, _SURE
    if clause.kind in _GOES and named is not None and clause.tail.cut(0, _NEAR + 3).says({"event"}):
        return *named, _SURE  # "entered a ditch (Event 1)"
    if clause.kind in {"own", "collide"} and clause.tail.has("collision") and named is not None:
        return *named, _TOLD
    return None


def _first(words: Words) -> tuple[StruckObject, Span] | None:
    return next(((thing, item.span) for item in words if (thing := _thing(item)) is not None), None)


def _thing(item: Item) -> StruckObject | None:
    if item.get("walker") == "animal":
        return StruckObject.ANIMAL
    if not item.is_a("object"):
        return None
    return _known_things().get(squeeze(item.low), StruckObject.OTHER)


@functools.cache
def _known_things() -> Mapping[str, StruckObject]:
    """What the words of the table stand for."""
    return {squeeze(word): StruckObject(name) for name, words in read_table("things").items() for word in words}


def _with(clause: Clause) -> Side | None:
    """The side with which the subject strikes."""
    if clause.subject.part is not None and not clause.is_passive:
        return clause.subject.part.side
    for lead, actor in clause.others:
        if actor.part is not None and lead.low in {"with", "by", "using"}:
            return actor.part.side
    for place, item in enumerate(clause.tail):
        if item.low == "with":
            hand = clause.tail.cut(place + 1, place + 1 + _HAND).first("hand")
            if hand is not None:
                return Side(hand.get("hand"))
    return None


def _roadside(text: Text, impact: _Impact) -> tuple[str, Span] | None:
    """The side of the road that is named last before an impact, or else in its sentence."""
    summary = text.summary
    places = sorted(
        (match.start("side"), match.end(), match["side"].lower()) for each in _PLACE for match in each.finditer(summary)
    )
    before = [each for each in places if each[0] < impact.where.start]
    stop = summary.find(".", impact.where.end)
    after = [each for each in places if impact.where.end <= each[0] < (stop if stop >= 0 else len(summary))]
    chosen = before[-1] if before else after[0] if after else None
    return None if chosen is None else (chosen[2], Span(chosen[0], chosen[1]))
