"""Which way the vehicles travel."""

import itertools
from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, Span
from roadmend.safe.compass import opposite
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import (
    TOWARDS,
    Text,
    claim,
    crash_places,
    direction,
    of_vehicle,
    rest_of,
    spoken_of,
    weakened,
)
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.manoeuvres import turn_of
from roadmend.safe.reading.naming import Mention
from roadmend.safe.reading.places import read_places
from roadmend.safe.reading.tokens import Item, Words

_NOT_GOING = frozenset({*STRIKES, "collide", "turn", "uturn", "reverse", "after", "flip"})
_SKIPPED = ("hand", "lanekind", "number", "ordinal", "determiner", "descriptor", "pronoun", "path", "stationary")
_REASONS = {
    "initial_position": "it is said to travel that way",
    "origin": "it is said to come from there",
    "against": "it entered the lane of those who come towards it",
    "destination": "it is said to go that way after its turn",
    "heading_on": "it meant to go on that way",
}


def read_ways(text: Text) -> Iterator[Claim]:
    """The claims of a text about directions of travel."""
    told = list(_told(text))
    yield from told
    yield from _unclaimed(text, told)


def _told(text: Text) -> Iterator[Claim]:
    afterwards = crash_places(text.clauses)
    turned: set[tuple[int, tuple[int, ...]]] = set()  # who is said to turn, by sentence
    beside = list(_beside_mentions(text))
    owners = {each.where.start: each.path for each in beside if isinstance(each.where, Span)}
    for place, clause in enumerate(text.clauses):
        who = (clause.sentence.index, clause.subject.vehicles)
        before = text.clauses[place - 1] if place else clause
        stood = before.kind in {"stop", "park"} and before.sentence is clause.sentence
        for each in _of_clause(clause, is_after=afterwards[place], has_turned=who in turned, stood=stood):
            start = each.where.start if isinstance(each.where, Span) else -1
            if owners.get(start, each.path) == each.path or not each.path.endswith("initial_position"):
                yield each
        if turn_of(clause) is not None:
            turned.add(who)
        yield from _between(clause)
    yield from _of_place(text)
    yield from read_places(text)
    yield from beside
    for mention in itertools.chain(*text.spoken.mentions):
        for trait in mention.traits if len(mention.vehicles) == 1 else ():
            if (way := direction(trait)) is not None:
                path = of_vehicle(mention.vehicles[0], "initial_position")
                yield claim(path, way, 0.93, f"it is called {trait.low}", trait)


def _of_clause(clause: Clause, *, is_after: bool, has_turned: bool, stood: bool) -> Iterator[Claim]:
    rest = rest_of(clause.sentence)
    faces = clause.lemma == "face" and (not is_after or stood or bool(clause.governed & {"stop", "park"}))
    for item in clause.tail.cut(0, 3) if faces and clause.span.end < rest else ():
        for vehicle in clause.subject.vehicles:
            if (way := direction(item)) is not None:
                yield claim(of_vehicle(vehicle, "initial_position"), way, 0.9, "it is said to face that way", item)
    for items, is_head in ((clause.head, True), (clause.tail, False)):
        for place, item in enumerate(items):
            way = direction(item)
            if way is None or (clause.is_denied and clause.kind not in {"stop", "avoid"}) or item.span.start > rest:
                continue
            what, confidence = _meaning(clause, items, place, is_head=is_head) or ("", 0.0)
            turn = turn_of(clause)
            before = any(each.low in {"had", "had been"} for each in clause.head)  # "where I had been going south"
            turned_here = turn is not None and clause.kind != "turn" and turn[2].end <= item.span.start
            if what in {"initial_position", "heading_on"} and _is_meant(clause.sentence.items, item):
                what = "destination"
            if (
                ((has_turned and not before) or turned_here)
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


def _between(clause: Clause) -> Iterator[Claim]:
    """A way between two of the four, "traveling northeast": it may be called either."""
    rest, words = rest_of(clause.sentence), clause.words
    goes = clause.kind in {"", "travel", "approach", "continue"} and not clause.is_denied
    for place, item in enumerate(words if goes else ()):
        letters = item.get("compass") or ""
        told = len(letters) > 1 and item.span.start < rest and words.at(place + 1).low not in word_set("not_a_way")
        for vehicle, letter in itertools.product(clause.subject.vehicles if told else (), letters):
            path = of_vehicle(vehicle, "initial_position")
            yield claim(path, TOWARDS[letter], 0.6, "it is said to travel about that way", item)


def _is_meant(items: Words, item: Item) -> bool:
    """Whether a way is the one after a turn of which the sentence tells: "left turn to go wb", "a right to head north"."""
    place = items.index(item)
    verb = items.at(place - 1).verb
    goes = verb is not None and verb.kind == "travel" and verb.form == "base" and items.at(place - 2).low == "to"
    turns = any(each.is_a("lanekind", "hand") or (each.verb is not None and each.verb.kind == "turn") for each in items)
    return goes and turns


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
    is_that = lead == "'s" and items.at(back - 1).low in {"that", "which", "it"}
    if is_that or items.at(back).get("relative") or lead in word_set("that_is"):
        return _explained(items, back)
    if kind == "depart" and "intend" in clause.governed and clause.lemma == "go":
        return "destination", 0.75
    near = place <= 5 or (lead in {"to", "toward", "towards"} and place <= 9) or items.says(word_set("heading_words"))
    if kind in {"travel", "continue", "approach", "follow"} and near and not is_head:
        goes_on = "intend" in clause.governed or kind == "continue"
        sure = 0.85 if lead in {"to", "toward", "towards"} else 0.96
        return "heading_on" if goes_on else "initial_position", sure
    is_word = len(item.low) > 1 or item.text.isupper()
    return ("initial_position", 0.8) if (is_head or kind == "") and is_word and after is not item else None


def _beside_mentions(text: Text) -> Iterator[Claim]:
    """Directions directly after the name of a vehicle: "struck another sedan, eastbound on Main", "V1 DIR: E"."""
    ended: Mention | None = None  # with which the sentence before closes
    for sentence, mentions in zip(text.sentences, text.spoken.mentions, strict=True):
        items = sentence.items
        opened = [(ended, 0)] if ended is not None else []
        for mention, start in [*((each, each.last + 1) for each in mentions), *opened]:
            at = start
            while items.at(at).low in word_set("beside_fillers"):
                at += 1
            is_form = items.at(at).low in word_set("form_ways") and items.at(at + 1).low == ":"
            item, after = items.at(at + 2 * is_form), items.at(at + 2 * is_form + 1)
            named = item.is_a("bound") and not item.low.endswith(("ward", "wards"))
            way = direction(item) if named or is_form else None
            if len(mention.vehicles) == 1 and way is not None and not after.is_a("lane", "road", "lanekind"):
                path = of_vehicle(mention.vehicles[0], "initial_position")
                yield claim(path, way, 0.85, "it is said to travel that way", item)
        ended = next((each for each in mentions if each.last == len(items) - 1), None)


def _unclaimed(text: Text, claims: Sequence[Claim]) -> Iterator[Claim]:
    """A direction that is said of nobody: weakly, of everybody of whom none is said."""
    known = {each.path for each in claims if each.path.endswith("initial_position")}
    spans = {(each.where.start, each.where.end) for each in claims if isinstance(each.where, Span)}
    open_ = [each for each in range(text.count) if of_vehicle(each, "initial_position") not in known]
    for sentence in text.sentences if open_ else ():
        for place, item in enumerate(sentence.items):
            lead, way = sentence.items.at(place - 1), direction(item)
            goes = item.is_a("bound") or lead.low in word_set("goes_that_way") or lead.get("verb") is not None
            goes &= not _is_of_name(sentence.items, place)
            goes &= item.span.start < rest_of(sentence) and not _is_meant(sentence.items, item)
            if way is None or not goes or (item.span.start, item.span.end) in spans or item.is_a("ends"):
                continue
            if sentence.items.at(place + 1).low in word_set("not_a_way") or sentence.items.cut(place - 6, place).has(
                "ends"
            ):
                continue
            counted = [at for at in range(max(0, place - 4), place + 3) if sentence.items.at(at).is_a("number", "lane")]
            listed = sentence.items.cut(place - 3, place).has("number") and sentence.items.has("lane")
            if listed or {sentence.items.at(at).is_a("lane") for at in counted} == {True, False}:
                continue  # "two lanes southbound", "one lane going south and two coming north"
            near = spoken_of(text, sentence, item.span)
            for vehicle in open_:
                path = of_vehicle(vehicle, "initial_position")
                sure = 0.75 if near == vehicle else 0.55 if near in open_ else 0.6
                yield claim(path, way, sure, "the text speaks of that direction", item)


def _explained(items: Words, place: int) -> tuple[str, float] | None:
    """What "that is north" explains: where one comes from, or goes."""
    before = items.cut(place - 8, place)
    if before.says({"from"}):
        return "origin", 0.75
    heads = before.says({"to", "toward", "towards", "for", "up", "down"}) or before.has("path")
    return ("initial_position", 0.75) if heads or "direction" in {each.low for each in before} else None


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
    if (after.low in word_set("not_a_way") and not (after.low == "side" and item.is_a("bound"))) or (
        after.is_a("shoulder") and not item.is_a("bound")
    ):
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
