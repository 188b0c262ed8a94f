"""How the ways of two vehicles lie to each other: the same, opposite, crossing from the left or the right."""

import itertools
from collections.abc import Iterator
from dataclasses import replace

from roadmend.safe.claims import DirectionClaim, WayRelation
from roadmend.safe.dsl import Side
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, relation
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.tokens import Item

_BEHIND = frozenset({"", "travel", "stop", "slow", "follow", "approach", "park", "change_lane", "own"})
_IN_FRONT = frozenset({"", "stop", "slow", "travel", "park"})  # "pulled out in front of" says nothing of the way
_COMES = frozenset({"travel", "approach", "emerge", "", "see"})
_FROM = {Side.LEFT: WayRelation.FROM_LEFT, Side.RIGHT: WayRelation.FROM_RIGHT}
_LONG = 9  # letters of "opposing": shorter words for it are too common


def read_relations(text: Text) -> Iterator[DirectionClaim]:
    """The claims of a text about how two ways lie to each other; left and right may be those of a bystander."""
    told = list(_told(text))
    hands = {each.relation: each for each in told if each.relation in _FROM.values()}
    if not text.spoken.roll.own() and len(hands) == len(_FROM):
        one, other = (hands[kind] for kind in _FROM.values())
        if one.second != other.second:
            yield replace(one, relation=WayRelation.OPPOSITE)
            told = [each for each in told if each.relation not in _FROM.values()]
    yield from told


def _told(text: Text) -> Iterator[DirectionClaim]:
    for clause in text.clauses:
        yield from _of_pairs(clause)
        yield from _of_words(clause, text.count)
    yield from _up_and_down(text)
    for mention in itertools.chain(*text.spoken.mentions):
        for trait in mention.traits if len(mention.vehicles) == 1 else ():
            others = [each for each in range(text.count) if each != mention.vehicles[0]]
            if trait.is_a("oncoming") and others:
                yield relation(others[0], mention.vehicles[0], WayRelation.OPPOSITE, 0.85, trait)


def _of_pairs(clause: Clause) -> Iterator[DirectionClaim]:
    """How two vehicles' ways lie to each other, where both are named: "V1 was behind V2"."""
    kind, mine = clause.kind, clause.subject.vehicles[:1]
    if not mine or clause.is_denied:
        return
    followed = clause.object.vehicles if clause.object is not None and kind in {"follow", "overtake"} else ()
    faced = clause.object.vehicles if clause.object is not None and clause.lemma == "face" else ()
    if faced and faced[0] != mine[0]:
        yield relation(mine[0], faced[0], WayRelation.OPPOSITE, 0.8, clause.span)
    if followed and followed[0] != mine[0]:
        yield relation(mine[0], followed[0], WayRelation.SAME, 0.88, clause.span)
    for lead, actor in clause.others:
        if not actor.vehicles or actor.vehicles[0] == mine[0]:
            continue
        side = _FROM.get(actor.part.side) if actor.part is not None and actor.part.side is not None else None
        if lead.low == "from" and side is not None and clause.kind in _COMES:  # "from my left-hand side"
            yield relation(actor.vehicles[0], mine[0], side, 0.8, lead)
        is_path = lead.is_a("path")
        noun = (
            bool(kind) and lead.span.end < clause.span.end and clause.span.start < lead.span.start
        )  # "the car ahead of me"
        beside = kind in (_IN_FRONT if is_path else _BEHIND) and clause.lemma != "come"
        if lead.is_a("ahead", "behind") and (beside or noun):
            yield relation(mine[0], actor.vehicles[0], WayRelation.SAME, 0.78 if is_path else 0.85, lead)
        elif lead.is_a("beside") and kind in {"", "travel", "stop"}:
            yield relation(mine[0], actor.vehicles[0], WayRelation.SAME, 0.75, lead)
        elif lead.is_a("oncoming") or (
            lead.low in word_set("towards") and actor.part is None and kind in {"travel", "approach"}
        ):
            yield relation(mine[0], actor.vehicles[0], WayRelation.OPPOSITE, 0.85, lead)
        elif (
            (lead.low == "on" and (_is_beside(clause) or _comes_up(clause)))
            or (lead.low in {"to", "of"} and clause.words.has("lane") and _is_beside(clause))
            or (lead.low == "like" and kind in {"travel", "continue"})
        ):
            yield relation(mine[0], actor.vehicles[0], WayRelation.SAME, 0.75, lead)


def _comes_up(clause: Clause) -> bool:
    """Whether somebody comes up on another from behind."""
    return clause.kind in {"travel", "approach"} and clause.lemma == "come" and clause.tail.at(0).low == "up"


def _up_and_down(text: Text) -> Iterator[DirectionClaim]:
    """One goes up and another comes down: they come towards each other."""
    ways: dict[str, dict[int, Item]] = {"up": {}, "down": {}}
    for clause in text.clauses:
        first = clause.tail.at(0)
        if clause.kind == "travel" and first.low in ways and not clause.tail.at(1).is_name:
            for vehicle in clause.subject.vehicles[:1]:
                ways[first.low].setdefault(vehicle, first)
    for up, down in itertools.product(ways["up"], ways["down"]):
        if up != down:
            yield relation(up, down, WayRelation.OPPOSITE, 0.75, ways["down"][down])


def _is_beside(clause: Clause) -> bool:
    """Whether a vehicle is "on my right" while it goes the same way."""
    on_part = clause.kind == "" and any(lead.low == "on" and actor.part is not None for lead, actor in clause.others)
    if on_part:
        return True  # "a van right on its bumper"
    return clause.kind in {"", "travel", "stop"} and clause.words.has("hand") and clause.lemma not in {"come", "appear"}


def _of_words(clause: Clause, count: int) -> Iterator[DirectionClaim]:
    """How ways lie to each other by a clause's words: "in the same direction", "from the left"."""
    kind, words, vehicles = clause.kind, clause.words, clause.subject.vehicles
    if not vehicles or (clause.is_denied and kind not in {"stop", "slow"}):
        return
    others = [each for each in range(count) if each not in vehicles]
    mine, other = (vehicles[0], vehicles[1]) if len(vehicles) > 1 else (vehicles[0], others[0] if others else None)
    if other is None:
        return
    counts = words.has("lane") and words.has("number")  # "two lanes, and two coming the other way"
    comes = not counts and (kind in STRIKES | {"travel", "", "approach", "drift", "collide"} or len(vehicles) > 1)
    for place, item in enumerate(words):
        far = len(item.low) > _LONG and not item.is_a("head_on", "wrong")
        far |= place == 0 and words.at(1).get("auxiliary") == "be"  # "Oncoming was a van"
        if (
            item.is_a("beside")
            and len(others) == 1
            and all(lead is not item for lead, _ in clause.others)
            and kind in {"travel", "", "drift", "change_lane"}
        ):
            yield relation(mine, other, WayRelation.SAME, 0.7, item)
        bare = item.is_a("behind") and words.at(place + 1).low in {"", ",", "and"} and len(others) == 1
        if bare and kind in _BEHIND:
            yield relation(mine, other, WayRelation.SAME, 0.75, item)
        if item.is_a("wrong") and words.cut(place - 2, place).says({"from"}):
            yield relation(mine, other, WayRelation.OPPOSITE, 0.8, item)
        if item.is_a("same_way") and "lane" not in item.low:
            yield relation(mine, other, WayRelation.SAME, 0.88, item)
        elif item.is_a("oncoming") and comes and (far or len(vehicles) > 1):
            to_me = len(vehicles) > 1 and item.low.endswith((" me", " us"))  # both come towards who watches
            yield relation(mine, other, WayRelation.SAME if to_me else WayRelation.OPPOSITE, 0.8, item)
        elif item.is_a("hand") and words.cut(place - 2, place).says({"from", "on"}) and len(vehicles) == 1:
            side = _FROM[Side(item.get("hand"))]
            led = {lead.low for lead, actor in clause.others if other in actor.vehicles}  # "from my left"
            # "out of a side road on my left"
            aside = kind == "emerge" and "on" in led and words.cut(0, place).has("road", "driveway")
            told, joined = words.cut(place - 2, place).says({"from"}), words.cut(place - 4, place)
            if told and item in clause.tail and joined.has("conjunction") and not joined.says({"and", "but"}):
                yield relation(mine, other, side, 0.8, item)  # "was going west when from the right a van came"
            elif aside or (told and (kind in _COMES or (kind in STRIKES and item in clause.head))):
                yield relation(other, mine, side, 0.82 if "from" in led or aside else 0.8, item)
