"""Which way the vehicles travel, and how their ways lie to each other."""

import itertools
from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, DirectionClaim, Relation
from roadmend.safe.compass import opposite
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, crash_places, direction, of_vehicle, relation, weakened
from roadmend.safe.reading.manoeuvres import turn_of
from roadmend.safe.reading.tokens import Item

_GOING = frozenset(
    {
        "",
        "travel",
        "continue",
        "approach",
        "stop",
        "slow",
        "park",
        "follow",
        "overtake",
        "intend",
        "begin",
        "change_lane",
        "drift",
        "fail",
        "emerge",
        "own",
        "do",
        "say",
        "see",
        "depart",
        "avoid",
    }
)
_TURNING = frozenset({"turn", "uturn"})
_INTO = frozenset(
    {
        "into",
        "onto",
        "on to",
        "across",
        "toward",
        "towards",
        "to",
        "over",
        "through",
        "cross",
        "crossed",
        "crosses",
        "crossing",
        "entered",
        "entering",
        "enter",
    }
)
_NOT_A_WAY = frozenset(
    {
        "side",
        "leg",
        "edge",
        "of",
        "end",
        "corner",
        "curb",
        "shoulder",
        "approach",
        "roadside",
        "/",
        "entrance",
        "traffic",
        "half",
        "part",
        "parking",
        "wall",
        "quadrant",
        "boundary",
        "facing",
    }
)
_SKIPPED = ("hand", "lanekind", "number", "ordinal", "determiner", "descriptor", "pronoun", "path", "stationary")
_HAPPENED = frozenset({"occurred", "happened", "took", "involved", "was", "occured"})
_FACING = frozenset({"face", "facing", "faced", "faces", "pointed", "pointing"})


def read_ways(text: Text) -> Iterator[Claim | DirectionClaim]:
    """The claims of a text about directions of travel."""
    afterwards = crash_places(text.clauses)
    sides = [
        item
        for sentence in text.sentences
        if any(item.is_a("driveway") for item in sentence.items[:4])
        for item in _sides(sentence.items)
    ]
    turned: set[tuple[int, tuple[int, ...]]] = set()  # who is said to turn, by sentence
    for place, clause in enumerate(text.clauses):
        who = (clause.sentence.index, clause.subject.vehicles if clause.subject is not None else ())
        yield from _of_clause(clause, is_after=afterwards[place], has_turned=who in turned)
        if turn_of(clause) is not None:
            turned.add(who)
        yield from _from_driveway(clause, sides)
        yield from _relations(clause, text.count)
    yield from _of_place(text)
    for row in text.spoken.mentions:
        for mention in row:
            for trait in mention.traits:
                way = direction(trait)
                others = [each for each in range(text.count) if each not in mention.vehicles]
                if trait.is_a("oncoming") and len(mention.vehicles) == 1 and others:
                    yield relation(
                        others[0], mention.vehicles[0], Relation.OPPOSITE, 0.85, f"it is called {trait.low}", trait.span
                    )
                if way is not None and len(mention.vehicles) == 1:
                    yield claim(
                        of_vehicle(mention.vehicles[0], "initial_position"),
                        way,
                        0.93,
                        f"it is called {trait.low}",
                        trait.span,
                    )


def _of_clause(clause: Clause, *, is_after: bool, has_turned: bool) -> Iterator[Claim]:
    if clause.subject is None or not clause.subject.vehicles:
        return
    if (
        clause.kind == "after"
        and clause.verb is not None
        and clause.verb.lemma == "face"
        and (not is_after or clause.governed & {"stop", "park"})
    ):
        for item in clause.tail[:3]:
            way = direction(item)
            if way is not None:
                for vehicle in clause.subject.vehicles:
                    yield claim(
                        of_vehicle(vehicle, "initial_position"), way, 0.9, "it is said to face that way", item.span
                    )
    for items, is_head in ((clause.head, True), (clause.tail, False)):
        for place, item in enumerate(items):
            way = direction(item)
            if way is None or (clause.is_denied and clause.kind not in {"stop", "avoid"}):
                continue
            found = _meaning(clause, items, place, is_head=is_head)
            if found is None:
                continue
            what, confidence = found
            if has_turned and not is_head and item.is_a("compass") and what in {"initial_position", "heading_on"}:
                what = "destination"
            if what in {"origin", "against"}:
                what, way = "initial_position", opposite(way)
            for vehicle in clause.subject.vehicles:
                yield claim(
                    of_vehicle(vehicle, what),
                    way,
                    weakened(confidence, is_after=is_after),
                    _REASONS[what if what in _REASONS else found[0]],
                    item.span,
                )


_REASONS = {
    "initial_position": "it is said to travel that way",
    "origin": "it is said to come from there",
    "against": "it entered the lane of those who come towards it",
    "destination": "it is said to go that way after its turn",
}


def _meaning(clause: Clause, items: Sequence[Item], place: int, *, is_head: bool) -> tuple[str, float] | None:
    """What a direction says of a clause's subject: how it came, or where it goes."""
    item, kind = items[place], clause.kind
    after = items[place + 1] if place + 1 < len(items) else None
    if kind in STRIKES | {"collide"} and not is_head:
        return None
    if item.low in {"sb", "s b"} and after is not None and after.low in {"used", "worn", "in use"}:
        return None  # a seat belt
    if any(each.is_a("ends") or each.low in {"joins", "enters", "tees"} for each in items[max(0, place - 6) : place]):
        return None  # a road that comes from there
    if any(each.is_a("weather") for each in items[max(0, place - 3) : place]):
        return None  # "winds from the south"
    if kind == "after":
        return None
    if after is not None and (after.low in _NOT_A_WAY or (after.is_a("shoulder") and not item.is_a("bound"))):
        return None
    if any(each.low in _FACING for each in items[max(0, place - 4) : place]):
        return "initial_position", 0.9 if kind in {"park", "stop", ""} else 0.7
    ahead = place + 1
    while ahead < len(items) and items[ahead].is_a(*_SKIPPED) and not items[ahead].is_a("lane", "road"):
        ahead += 1
    names_road = (
        ahead < len(items)
        and items[ahead].is_a("lane", "road", "shoulder", "ramp")
        and not any(each.low in ",;" for each in items[place:ahead])
    )
    back = place - 1
    while back >= 0 and items[back].is_a(*_SKIPPED) and not items[back].is_a("preposition"):
        back -= 1
    lead = items[back].low if back >= 0 else (clause.verb.lemma if clause.verb is not None and not is_head else "")
    if kind in _TURNING and not is_head:
        if lead == "from":
            return ("initial_position", 0.85) if names_road or item.is_a("bound") else ("origin", 0.8)
        return "destination", 0.85
    if names_road and item.is_a("bound", "compass"):
        if lead in _INTO:
            if kind in {"drift", "depart"} or (
                kind in {"approach", "travel", "change_lane"}
                and any(each.is_a("centerline", "wrong") for each in items[:place])
            ):
                return "against", 0.75
            return ("destination", 0.7) if kind in {"emerge", "approach"} and lead in {"onto", "on to"} else None
        if item.is_a("compass") and not items[ahead].is_a("lane"):
            return None
        return "initial_position", 0.9 if kind in _GOING else 0.6
    if item.is_a("compass"):
        if lead == "from":
            return "origin", 0.88
        if lead in {"of", "at"}:
            return None
        near = place <= 5 or any(
            each.low in {"heading", "headed", "travelling", "traveling", "direction", "facing"} for each in items
        )
        if kind in {"travel", "continue", "approach", "follow"} and near and not is_head:
            goes_on = "intend" in clause.governed or kind == "continue"
            return "initial_position" if not goes_on else "heading_on", 0.96 if lead not in {
                "to",
                "toward",
                "towards",
            } else 0.85
        if is_head or kind == "":
            return ("initial_position", 0.8) if len(item.low) > 1 or item.text.isupper() else None
        return None
    return "initial_position", 0.96 if kind in _GOING else 0.7


_REASONS["heading_on"] = "it meant to go on that way"


def _of_place(text: Text) -> Iterator[Claim]:
    """Where the crash was: "the crash occurred in the northbound lanes of a divided road"."""
    for sentence, mentions in zip(text.sentences, text.spoken.mentions, strict=True):
        head = sentence.items[:8]
        told = any(item.is_a("collision") for item in head) and any(item.low in _HAPPENED for item in head)
        ways = [item for item in sentence.items if item.is_a("bound")]
        apart = any(item.is_a("axis", "junction") for item in sentence.items)
        if (
            told
            and not apart
            and len({direction(item) for item in ways}) == 1
            and not any(each.vehicles for each in mentions)
        ):
            for vehicle in range(text.count):
                path = of_vehicle(vehicle, "initial_position")
                yield claim(path, direction(ways[0]), 0.68, "the crash was on that side of the road", ways[0].span)


def _from_driveway(clause: Clause, sides: Sequence[Item]) -> Iterator[Claim]:
    """Who comes out of a driveway on the east side of a street heads west."""
    words = [*clause.head, *clause.tail]
    if clause.subject is None or clause.kind not in {"emerge", "travel", "reverse", "depart"}:
        return
    place = next((place for place, item in enumerate(words) if item.is_a("driveway")), None)
    backs = clause.kind == "reverse" or any(item.verb is not None and item.verb.kind == "reverse" for item in words)
    if place is None or backs or any(item.low in {"into", "to", "toward"} for item in words[max(0, place - 3) : place]):
        return
    for item in _sides(words) or sides:
        way = direction(item)
        for vehicle in clause.subject.vehicles[:1]:
            if way is not None:
                path = of_vehicle(vehicle, "initial_position")
                yield claim(path, opposite(way), 0.85, f"it comes from the {item.low} side", item.span)


def _sides(items: Sequence[Item]) -> list[Item]:
    """Sides of a road that are named: "on the east side"."""
    pairs = itertools.pairwise(items)
    return [one for one, after in pairs if one.is_a("compass") and direction(one) and after.low in {"side", "edge"}]


def _relations(clause: Clause, count: int) -> Iterator[DirectionClaim]:
    subject = clause.subject
    if subject is None or not subject.vehicles or clause.is_denied:
        return
    mine = subject.vehicles[0]
    others = [each for each in range(count) if each not in subject.vehicles]
    if (
        clause.kind in {"follow", "overtake"}
        and clause.object is not None
        and clause.object.vehicles
        and clause.object.vehicles[0] != mine
    ):
        yield relation(
            mine, clause.object.vehicles[0], Relation.SAME, 0.88, "the one follows or passes the other", clause.span
        )
    for lead, actor in clause.others:
        if not actor.vehicles or actor.vehicles[0] == mine:
            continue
        if (
            lead.is_a("ahead", "behind")
            and clause.kind in {"", "travel", "stop", "slow", "follow", "approach", "park", "change_lane", "own"}
            and (not lead.is_a("path") or clause.kind in {"", "stop", "slow", "travel", "park"})
        ):
            if clause.verb is None or clause.verb.lemma != "come":
                yield relation(
                    mine,
                    actor.vehicles[0],
                    Relation.SAME,
                    0.85 if not lead.is_a("path") else 0.78,
                    f"the one was {lead.low} the other",
                    lead.span,
                )
        elif lead.is_a("beside") and clause.kind in {"", "travel", "stop"}:
            yield relation(mine, actor.vehicles[0], Relation.SAME, 0.75, f"the one was {lead.low} the other", lead.span)
        elif lead.is_a("oncoming"):
            yield relation(
                mine, actor.vehicles[0], Relation.OPPOSITE, 0.85, "the one came towards the other", lead.span
            )
    words = [*clause.head, *clause.tail]
    if len(others) == 1 or (count > 2 and others):
        other = others[0]
        for place, item in enumerate(words):
            if item.is_a("beside") and len(others) == 1 and clause.kind in {"travel", "", "drift", "change_lane"}:
                yield relation(mine, other, Relation.SAME, 0.7, f"the one was in the {item.low}", item.span)
            if item.is_a("same_way") and "lane" not in item.low:
                yield relation(mine, other, Relation.SAME, 0.88, "they are said to go the same way", item.span)
            elif (
                item.is_a("oncoming")
                and clause.kind in {"travel", "", "approach", "drift", "collide"} | STRIKES
                and not item.is_a("head_on")
                and not item.is_a("wrong")
                and len(item.low) > 9
            ):
                yield relation(mine, other, Relation.OPPOSITE, 0.8, "they are said to go opposite ways", item.span)
            elif (
                item.is_a("hand")
                and place
                and any(each.low == "from" for each in words[max(0, place - 2) : place])
                and clause.kind in {"travel", "approach", "emerge", "", "see"}
            ):
                side = Relation.FROM_LEFT if item.kinds["hand"] == "Left" else Relation.FROM_RIGHT
                yield relation(other, mine, side, 0.7, f"it is said to come from the {item.low}", item.span)
    if len(subject.vehicles) > 1:
        for item in words:
            if item.is_a("oncoming"):
                yield relation(
                    subject.vehicles[0],
                    subject.vehicles[1],
                    Relation.OPPOSITE,
                    0.85,
                    "they are said to go opposite ways",
                    item.span,
                )
            elif item.is_a("same_way"):
                yield relation(
                    subject.vehicles[0],
                    subject.vehicles[1],
                    Relation.SAME,
                    0.85,
                    "they are said to go the same way",
                    item.span,
                )
