"""What the parts of the reader share: the claims they make of the summary, and the directions of its words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from roadmend.safe.claims import Claim, ClaimSource, DirectionClaim, Span, WayRelation
from roadmend.safe.dsl import Position
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.mentions import Spoken
from roadmend.safe.reading.tokens import Item, Sentence

TOWARDS = {"N": Position.S2N, "S": Position.N2S, "E": Position.W2E, "W": Position.E2W}
AXES = {"NS": frozenset({Position.S2N, Position.N2S}), "EW": frozenset({Position.W2E, Position.E2W})}
GOES = frozenset({"travel", "turn", "approach", "emerge", "continue", "change_lane", "overtake", "follow", "drift"})
_AFTERWARDS = 0.86  # of its confidence is left to what is told after the crash


@dataclass(frozen=True, slots=True)
class Text:
    """A summary taken apart."""

    summary: str
    sentences: tuple[Sentence, ...]
    spoken: Spoken
    clauses: tuple[Clause, ...]

    @property
    def count(self) -> int:
        """Vehicles that the text speaks of."""
        return len(self.spoken.roll.vehicles)


def claim(path: str, value: Any, confidence: float, reason: str, where: Item | Span | None) -> Claim:
    """A claim that the summary makes."""
    place = where.span if isinstance(where, Item) else where
    return Claim(path, value, confidence, ClaimSource.SUMMARY, reason, place)


def of_vehicle(vehicle: int, field: str) -> str:
    """The path of a vehicle's field."""
    return f"vehicles[{vehicle}].{field}"


def relation(first: int, second: int, kind: WayRelation, confidence: float, where: Item | Span) -> DirectionClaim:
    """A claim that the summary makes of two ways."""
    place = where.span if isinstance(where, Item) else where
    return DirectionClaim(first, second, kind, confidence, ClaimSource.SUMMARY, f"the text tells: {kind}", place)


def direction(item: Item) -> Position | None:
    """The way that a word points: "northbound", "north"."""
    return TOWARDS.get(item.get("bound") or item.get("compass") or "")


def crash_places(clauses: Sequence[Clause]) -> dict[int, bool]:
    """By place of a clause: whether vehicles have touched before it; what a text begins with is told again afterwards."""
    begins = (
        each.sentence.index for each in clauses if each.subject.vehicles and (each.kind in GOES or _touches(each))
    )
    first = next(begins, 0)
    touched, found = False, {}
    for place, clause in enumerate(clauses):
        found[place] = touched or (clause.kind == "after" and clause.lemma != "face")
        touched |= _touches(clause) and clause.sentence.index > first
    return found


def _touches(clause: Clause) -> bool:
    struck = clause.object is not None and bool(clause.object.vehicles)
    if not clause.is_real or not (clause.subject.vehicles or struck):
        return False
    one, several = clause.kind in STRIKES, clause.kind == "collide" and len(clause.subject.vehicles) > 1
    with_other = clause.object is not None and (one or clause.kind == "collide")
    return with_other or several or (one and (clause.is_passive or bool(clause.others)))


def spoken_of(text: Text, sentence: Sentence, where: Span) -> int | None:
    """The vehicle of which a sentence speaks last before a place; its only one, where it speaks of none before."""
    spoken = text.spoken.mentions[sentence.index]
    mentions = [each for each in spoken if sentence.items[each.first].low not in word_set("object_pronouns")]
    before = [each for each in mentions if sentence.items[each.first].span.start < where.start]
    near = before[-1:] or (mentions if len(mentions) == 1 else [])
    return near[0].vehicles[0] if near and len(near[0].vehicles) == 1 else None


def rest_of(sentence: Sentence) -> float:
    """The place in the summary from which a sentence tells where a vehicle was in the end; infinite where it does not."""
    told = (each for each in sentence.items if each.verb is not None and each.verb.kind == "after")
    ends = [each.span.start for each in told if each.verb is not None and each.verb.lemma in word_set("rests")]
    ends += [each.span.start for each in sentence.items if each.low in word_set("at_rest")]
    return min(ends, default=math.inf)


def weakened(confidence: float, *, is_after: bool) -> float:
    """The confidence of what may belong to the time after the crash."""
    return confidence * _AFTERWARDS if is_after else confidence
