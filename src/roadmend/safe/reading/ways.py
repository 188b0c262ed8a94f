"""Which way the vehicles travel, and how their ways lie to each other."""

import itertools
from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, DirectionClaim, Span, WayRelation
from roadmend.safe.compass import opposite
from roadmend.safe.dsl import Side
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, crash_places, direction, of_vehicle, relation, weakened
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.manoeuvres import turn_of
from roadmend.safe.reading.tokens import Item, Words

_NOT_GOING = frozenset({*STRIKES, "collide", "turn", "uturn", "reverse", "after", "flip"})
_SKIPPED = ("hand", "lanekind", "number", "ordinal", "determiner", "descriptor", "pronoun", "path", "stationary")
_BEHIND = frozenset({"", "travel", "stop", "slow", "follow", "approach", "park", "change_lane", "own"})
_IN_FRONT = frozenset({"", "stop", "slow", "travel", "park"})  # "pulled out in front of" says nothing of the way
_COMES = frozenset({"travel", "approach", "emerge", "", "see"})
_FROM = {Side.LEFT: WayRelation.FROM_LEFT, Side.RIGHT: WayRelation.FROM_RIGHT}
_LONG = 9  # letters of "opposing": shorter words for it are too common
_REASONS = {
    "initial_position": "it is said to travel that way",
    "origin": "it is said to come from there",
    "against": "it entered the lane of those who come towards it",
    "destination": "it is said to go that way after its turn",
    "heading_on": "it meant to go on that way",
}


def read_ways(text: Text) -> Iterator[Claim | DirectionClaim]:
    """The claims of a text about directions of travel."""
    told = list(_told(text))
    yield from told
    yield from _unclaimed(text, told)


def _told(text: Text) -> Iterator[Claim | DirectionClaim]:
    afterwards = crash_places(text.clauses)
    sides = [side for each in text.sentences if each.items.cut(0, 4).has("driveway") for side in _sides(each.items)]
    turned: set[tuple[int, tuple[int, ...]]] = set()  # who is said to turn, by sentence
    for place, clause in enumerate(text.clauses):
        who = (clause.sentence.index, clause.subject.vehicles)
        before = text.clauses[place - 1] if place else clause
        stood = before.kind in {"stop", "park"} and before.sentence is clause.sentence
        yield from _of_clause(clause, is_after=afterwards[place], has_turned=who in turned, stood=stood)
        if turn_of(clause) is not None:
            turned.add(who)
        yield from _from_driveway(clause, sides)
        yield from _of_pairs(clause)
        yield from _of_words(clause, text.count)
    yield from _of_place(text)
    yield from _beside_mentions(text)
    for mention in itertools.chain(*text.spoken.mentions):
        for trait in mention.traits if len(mention.vehicles) == 1 else ():
            mine, way = mention.vehicles[0], direction(trait)
            others = [each for each in range(text.count) if each != mine]
            if trait.is_a("oncoming") and others:
                yield relation(others[0], mine, WayRelation.OPPOSITE, 0.85, trait)
            if way is not None:
                yield claim(of_vehicle(mine, "initial_position"), way, 0.93, f"it is called {trait.low}", trait)


def _of_clause(clause: Clause, *, is_after: bool, has_turned: bool, stood: bool) -> Iterator[Claim]:
    faces = clause.lemma == "face" and (not is_after or stood or bool(clause.governed & {"stop", "park"}))
    for item in clause.tail.cut(0, 3) if faces else ():
        for vehicle in clause.subject.vehicles:
            if (way := direction(item)) is not None:
                yield claim(of_vehicle(vehicle, "initial_position"), way, 0.9, "it is said to face that way", item)
    for items, is_head in ((clause.head, True), (clause.tail, False)):
        for place, item in enumerate(items):
            way = direction(item)
            if way is None or (clause.is_denied and clause.kind not in {"stop", "avoid"}):
                continue
            what, confidence = _meaning(clause, items, place, is_head=is_head) or ("", 0.0)
            turn = turn_of(clause)
            turned_here = turn is not None and clause.kind != "turn" and turn[2].end <= item.span.start
            if (
                (has_turned or turned_here)
                and not is_head
                and (item.is_a("compass") or _is_aim(clause, items, place))
                and what in {"initial_position", "heading_on"}
            ):
                what = "destination"
            turned_round = what in {"origin", "against"}
            for vehicle in clause.subject.vehicles if what else ():
                path = of_vehicle(vehicle, "initial_position" if turned_round else what)
                sure = weakened(confidence, is_after=is_after)
                yield claim(path, opposite(way) if turned_round else way, sure, _REASONS[what], item)


def _is_aim(clause: Clause, items: Words, place: int) -> bool:
    """Whether "northbound" is where one wants to go: "a left turn to eastbound 96", "a right to go north bound"."""
    led = items.at(place - 1).low in word_set("aims")
    return led or (clause.kind == "travel" and clause.verb is not None and clause.verb.form == "base")


def _meaning(clause: Clause, items: Words, place: int, *, is_head: bool) -> tuple[str, float] | None:
    """What a direction says of a clause's subject: how it came, or where it goes."""
    item, after, kind = items[place], items.at(place + 1), clause.kind
    at_road = items.cut(place - 4, place).says({"on"}) and item.is_a("bound") and not after.is_a("lane", "lanekind")
    if kind in STRIKES and not is_head and at_road:
        return "initial_position", 0.68  # "struck it on the M5 southbound"
    if _is_no_way(clause, items, place, is_head=is_head):
        return None
    if items.cut(place - 6, place).says(word_set("facing")):
        return "initial_position", 0.9 if kind in {"park", "stop", ""} else 0.7
    ahead, back = place + 1, place - 1
    while items.at(ahead).is_a(*_SKIPPED) and not items.at(ahead).is_a("lane", "road"):
        ahead += 1
    while items.at(back).is_a(*_SKIPPED) and not items.at(back).is_a("preposition"):
        back -= 1
    lead = items.at(back).low if back >= 0 else "" if is_head else clause.lemma
    names_road = items.at(ahead).is_a("lane", "road", "shoulder", "ramp") and not items.cut(place, ahead).says(",;")
    if kind in {"turn", "uturn"} and not is_head:
        if lead == "from":
            return ("initial_position", 0.85) if names_road or item.is_a("bound") else ("origin", 0.8)
        return "destination", 0.85
    if names_road:
        return _of_lane(clause, items, place, lead, is_lane=items.at(ahead).is_a("lane"))
    if not item.is_a("compass"):
        return "initial_position", 0.96 if is_head or kind not in _NOT_GOING else 0.7
    comes_out = lead == "out of" or (kind == "emerge" and lead == clause.lemma == "come")
    if lead == "from" or (comes_out and not after.is_a("driveway")):
        return "origin", 0.88
    numbered = items.at(place - 1).is_a("number") or items.at(place - 1).low[-1:].isdigit()
    if numbered and item.is_a("compass") and kind in {"", "travel", "stop", "slow", "own", "merge", "follow"}:
        return "initial_position", 0.8  # "on 95 north"
    if lead in {"of", "at"} and items.at(back - 1).low not in {"direction", "direction of"}:
        return None
    if items.at(back).get("relative") or lead in word_set("that_is"):
        return _explained(items, back)
    if kind == "depart" and "intend" in clause.governed and clause.lemma == "go":
        return "destination", 0.75
    near = place <= 5 or items.says(word_set("heading_words"))
    if kind in {"travel", "continue", "approach", "follow"} and near and not is_head:
        goes_on = "intend" in clause.governed or kind == "continue"
        sure = 0.85 if lead in {"to", "toward", "towards"} else 0.96
        return "heading_on" if goes_on else "initial_position", sure
    is_word = len(item.low) > 1 or item.text.isupper()
    return ("initial_position", 0.8) if (is_head or kind == "") and is_word and after is not item else None


def _beside_mentions(text: Text) -> Iterator[Claim]:
    """Directions directly after the name of a vehicle: "struck another sedan, eastbound on Main"."""
    for sentence, mentions in zip(text.sentences, text.spoken.mentions, strict=True):
        items = sentence.items
        for mention in mentions:
            at = mention.last + 1
            while items.at(at).low in word_set("beside_fillers"):
                at += 1
            item, after = items.at(at), items.at(at + 1)
            way = direction(item) if item.is_a("bound") else None
            if len(mention.vehicles) == 1 and way is not None and not after.is_a("lane", "road", "lanekind"):
                path = of_vehicle(mention.vehicles[0], "initial_position")
                yield claim(path, way, 0.85, "it is said to travel that way", item)


def _unclaimed(text: Text, claims: Sequence[Claim | DirectionClaim]) -> Iterator[Claim]:
    """A direction that is said of nobody: weakly, of everybody of whom none is said."""
    known = {each.path for each in claims if isinstance(each, Claim) and each.path.endswith("initial_position")}
    spans = {(each.where.start, each.where.end) for each in claims if isinstance(each.where, Span)}
    open_ = [each for each in range(text.count) if of_vehicle(each, "initial_position") not in known]
    for sentence in text.sentences if open_ else ():
        for place, item in enumerate(sentence.items):
            lead, way = sentence.items.at(place - 1), direction(item)
            goes = item.is_a("bound") or lead.low in word_set("goes_that_way") or lead.get("verb") is not None
            goes &= not _is_of_name(sentence.items, place)
            if way is None or not goes or (item.span.start, item.span.end) in spans or item.is_a("ends"):
                continue
            if sentence.items.at(place + 1).low in word_set("not_a_way") or sentence.items.cut(place - 6, place).has(
                "ends"
            ):
                continue
            counted = [at for at in range(max(0, place - 4), place + 3) if sentence.items.at(at).is_a("number", "lane")]
            if {sentence.items.at(at).is_a("lane") for at in counted} == {True, False}:
                continue  # "two lanes southbound"
            for vehicle in open_:
                path = of_vehicle(vehicle, "initial_position")
                yield claim(path, way, 0.6, "the text speaks of that direction", item)


def _explained(items: Words, place: int) -> tuple[str, float] | None:
    """What "that is north" explains: where one comes from, or goes."""
    before = items.cut(place - 8, place)
    if before.says({"from"}):
        return "origin", 0.75
    return ("initial_position", 0.75) if before.says({"to", "toward", "towards", "for", "up", "down"}) else None


def _is_of_name(items: Words, place: int) -> bool:
    """Whether a compass point is a part of a name: "near North Avenue", "on East Main Street", "to West Virginia"."""
    item, before, after = items[place], items.at(place - 1), items.at(place + 1)
    led = before.is_a("preposition", "determiner", "conjunction") or before.low in word_set("near")
    led |= before.low.endswith((" on", " to", " at"))
    named = after.is_a("road", "driveway") or items.at(place + 2).is_a("road", "driveway") or not after.kinds
    is_word = item.is_a("compass") and item.text.istitle() and len(item.low) > 1
    return is_word and led and after.is_name and named


def _is_no_way(clause: Clause, items: Words, place: int, *, is_head: bool) -> bool:
    """Whether a word for a direction says nothing of a way: a side, a wind, a road's, or one after the crash."""
    item, after = items[place], items.at(place + 1)
    if clause.kind == "after" or (clause.kind in STRIKES | {"collide"} and not is_head):
        return True
    if _is_of_name(items, place) or items.at(place - 1).low in word_set("titles"):
        return True
    if after.low in word_set("not_a_way") or (after.is_a("shoulder") and not item.is_a("bound")):
        return True
    belt = item.low in {"sb", "s b"} and after.low in {"used", "worn", "in use"}
    before = items.cut(place - 6, place)
    of_road = before.has("ends") or before.says({"joins", "enters", "tees"})
    return belt or of_road or items.cut(place - 3, place).has("weather")


def _of_lane(clause: Clause, items: Words, place: int, lead: str, *, is_lane: bool) -> tuple[str, float] | None:
    """What "northbound lane" says: of who is in it, that it travels that way; of who enters it, that it did not."""
    kind = clause.kind
    if lead in word_set("into"):
        strays = kind in {"approach", "travel", "change_lane"} and items.cut(0, place).has("centerline", "wrong")
        if kind in {"drift", "depart"} or strays:
            return "against", 0.75
        return ("destination", 0.7) if kind in {"emerge", "approach"} and lead in {"onto", "on to"} else None
    if items[place].is_a("compass") and not is_lane:
        return None
    return "initial_position", 0.9 if kind not in _NOT_GOING else 0.6


def _of_place(text: Text) -> Iterator[Claim]:
    """Where the crash was: "the crash occurred in the northbound lanes of a divided road"."""
    for sentence, mentions in zip(text.sentences, text.spoken.mentions, strict=True):
        head, bound = sentence.items.cut(0, 8), [item for item in sentence.items if item.is_a("bound")]
        told = head.has("collision") and head.says(word_set("happened")) and not sentence.items.has("axis", "junction")
        ways = {direction(item) for item in bound}
        for vehicle in (
            range(text.count) if told and len(ways) == 1 and not any(each.vehicles for each in mentions) else ()
        ):
            path = of_vehicle(vehicle, "initial_position")
            yield claim(path, direction(bound[0]), 0.68, "the crash was on that side of the road", bound[0])


def _from_driveway(clause: Clause, sides: Sequence[Item]) -> Iterator[Claim]:
    """Who comes out of a driveway on the east side of a street heads west."""
    words = clause.words
    place = next((place for place, item in enumerate(words) if item.is_a("driveway")), None)
    backs = any(item.verb is not None and item.verb.kind == "reverse" for item in words)
    if place is None or backs or clause.kind not in {"emerge", "travel", "depart"}:
        return
    if words.cut(place - 3, place).says({"into", "to", "toward"}):
        return
    for item in _sides(words) or sides:
        way = direction(item)
        for vehicle in clause.subject.vehicles[:1] if way is not None else ():
            path = of_vehicle(vehicle, "initial_position")
            yield claim(path, way and opposite(way), 0.85, f"it comes from the {item.low} side", item)


def _sides(items: Words) -> list[Item]:
    """Sides of a road that are named: "on the east side"."""
    pairs = itertools.pairwise(items)
    return [one for one, after in pairs if one.is_a("compass") and direction(one) and after.low in {"side", "edge"}]


def _of_pairs(clause: Clause) -> Iterator[DirectionClaim]:
    """How two vehicles' ways lie to each other, where both are named: "V1 was behind V2"."""
    kind, mine = clause.kind, clause.subject.vehicles[:1]
    if not mine or clause.is_denied:
        return
    followed = clause.object.vehicles if clause.object is not None and kind in {"follow", "overtake"} else ()
    if followed and followed[0] != mine[0]:
        yield relation(mine[0], followed[0], WayRelation.SAME, 0.88, clause.span)
    for lead, actor in clause.others:
        if not actor.vehicles or actor.vehicles[0] == mine[0]:
            continue
        side = _FROM.get(actor.part.side) if actor.part is not None and actor.part.side is not None else None
        if lead.low == "from" and side is not None and kind in _COMES:  # "from my left-hand side"
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
        elif lead.is_a("oncoming"):
            yield relation(mine[0], actor.vehicles[0], WayRelation.OPPOSITE, 0.85, lead)


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
        if item.is_a("beside") and len(others) == 1 and kind in {"travel", "", "drift", "change_lane"}:
            yield relation(mine, other, WayRelation.SAME, 0.7, item)
        bare = item.is_a("behind") and words.at(place + 1).low in {"", ",", "and"} and len(others) == 1
        if bare and kind in _BEHIND:
            yield relation(mine, other, WayRelation.SAME, 0.75, item)
        if item.is_a("wrong") and item.low.endswith("lane") and item.low.split()[0] in {"my", "our", "his", "her"}:
            yield relation(mine, other, WayRelation.OPPOSITE, 0.62, item)
        if item.is_a("same_way") and "lane" not in item.low:
            yield relation(mine, other, WayRelation.SAME, 0.88, item)
        elif item.is_a("oncoming") and comes and (far or len(vehicles) > 1):
            yield relation(mine, other, WayRelation.OPPOSITE, 0.8, item)
        elif item.is_a("hand") and words.cut(place - 2, place).says({"from", "on"}) and len(vehicles) == 1:
            side = _FROM[Side(item.get("hand"))]
            led = {lead.low for lead, actor in clause.others if other in actor.vehicles}  # "from my left"
            # "out of a side road on my left"
            aside = kind == "emerge" and "on" in led and words.cut(0, place).has("road", "driveway")
            told = kind in _COMES and words.cut(place - 2, place).says({"from"})
            if told or aside:
                yield relation(other, mine, side, 0.82 if "from" in led or aside else 0.7, item)
