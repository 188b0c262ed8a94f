"""What the vehicles do: turn, stand, change lane, come over the centre line."""

import itertools
from collections.abc import Iterator

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Action, Manoeuvre, Side
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, crash_places, of_vehicle, rest_of, spoken_of, weakened
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.tokens import Item, Words

_TURNS = {Side.LEFT: Action.TURN_LEFT, Side.RIGHT: Action.TURN_RIGHT}
_REACH = 4  # words between "turn" and "left"
_SHORT = {"l": "Left", "lt": "Left", "lh": "Left", "r": "Right", "rt": "Right", "rh": "Right"}
_OF_ANOTHER = 0.8  # of its confidence is left to what a sentence says of nobody whom it names
_STRAYS = frozenset({"drift", "approach", "depart", "travel", "change_lane"})
_IN_LANE = frozenset({"travel", "stop", "", "slow", "approach", "intend"})
_TURNING = frozenset({"turn", "do", "intend", "begin"})
_MAY_TURN = _IN_LANE | {"do", "begin", "fail", "continue", "emerge"}


def read_manoeuvres(text: Text) -> Iterator[Claim]:
    """The claims of a text about actions and manoeuvres."""
    afterwards = crash_places(text.clauses)
    for place, clause in enumerate(text.clauses):
        is_own = clause.subject.span.start >= clause.sentence.span.start
        denied = clause.is_denied or clause.head.has("negation") or clause.span.end > rest_of(clause.sentence)
        for what, value, confidence, reason, span in () if denied else _of_clause(clause):
            sure = weakened(confidence if is_own else _OF_ANOTHER * confidence, is_after=afterwards[place])
            near = spoken_of(text, clause.sentence, span) if isinstance(value, Action) else None
            if not (afterwards[place] and value is Manoeuvre.RUN_OFF):
                for vehicle in clause.subject.vehicles or (() if near is None else (near,)):
                    yield claim(of_vehicle(vehicle, what), value, sure, reason, span)
    for mention in itertools.chain(*text.spoken.mentions):
        for trait in mention.traits if mention.vehicles else ():
            path, reason = of_vehicle(mention.vehicles[0], "manoeuvre"), f"it is called {trait.low}"
            if trait.is_a("parked", "stationary"):
                yield claim(path, Manoeuvre.PARKED if trait.is_a("parked") else Manoeuvre.STOP, 0.9, reason, trait)


def _of_clause(clause: Clause) -> Iterator[tuple[str, Action | Manoeuvre, float, str, Span]]:
    turn, kind, governed = turn_of(clause), clause.kind, clause.governed
    if turn is not None:
        hand, confidence, span = turn
        limit = (
            0.86 if "stop" in governed or kind == "stop" else 0.92 if "intend" in governed or kind == "intend" else 1.0
        )
        yield "action", _TURNS[hand], min(confidence, limit), "it is said to turn, or to mean to turn, that way", span
    elif (
        clause.verb is not None
        and clause.lemma == "turn"
        and clause.verb.form != "base"
        and clause.tail.at(0).low in word_set("turn_targets") | {"for"}
    ):
        yield from (("action", each, 0.76, "it is said to turn", clause.span) for each in _TURNS.values())
    if kind in {"continue", "travel", "approach"}:
        straight = next(
            (item for item in clause.tail if item.low in word_set("straight_on") or item.is_a("straight")), None
        )
        if straight is not None and turn is None:
            yield "action", Action.MOVE_FORWARD, 0.85, "it is said to go straight on", straight.span
    if kind == "uturn":
        yield "action", Action.TURN_LEFT, 0.9, "a U-turn leads to the left", clause.span
    meant = bool(governed & {"intend", "avoid", "fail"})
    found = _manoeuvre(clause)
    if found is not None and not (meant and kind in {"stop", "drift", "depart"}):
        yield "manoeuvre", *found, "the text says so", clause.span


def _manoeuvre(clause: Clause) -> tuple[Manoeuvre, float] | None:
    kind, words = clause.kind, clause.words
    stood = clause.head if kind in STRIKES and clause.is_passive else words if kind == "" else Words()
    if kind == "park" or stood.has("parked"):
        return Manoeuvre.PARKED, 0.9
    if kind == "stop" or (stood.has("stationary") and clause.subject.part is None):
        return Manoeuvre.STOP, 0.75
    if kind in _STRAYS and (words.has("centerline", "wrong") or (kind != "change_lane" and _enters_own_lane(words))):
        return Manoeuvre.ENTER_THE_WRONG_WAY, 0.85
    if kind == "change_lane":
        return Manoeuvre.MERGE if clause.lemma in {"merge", "filter", "join"} else Manoeuvre.CHANGING_LANE, 0.8
    leaves = kind == "emerge" or (clause.lemma in {"leave", "exit"} and not words.has("road", "ramp"))
    if leaves and words.has("driveway"):
        return Manoeuvre.LEAVE_DRIVEWAY, 0.85
    if kind == "depart" and words.has("road", "shoulder"):
        return Manoeuvre.RUN_OFF, 0.8
    plain = {
        "uturn": (Manoeuvre.U_TURN, 0.9),
        "reverse": (Manoeuvre.REVERSE, 0.9),
        "overtake": (Manoeuvre.OVERTAKE, 0.7),
    }
    return plain.get(kind)


def _enters_own_lane(words: Words) -> bool:
    """Whether somebody came "into my lane", "into his lane"; who only drives "in my lane" is where he should be."""
    return any(each.is_a("own_lane") and words.at(at - 1).low in word_set("into") for at, each in enumerate(words))


def turn_of(clause: Clause) -> tuple[Side, float, Span] | None:
    """Which way a clause says that its subject turns, how surely, and where it says so."""
    for place, item in enumerate(
        clause.tail.cut(0, _REACH) if clause.kind in _TURNING or clause.lemma == "pull" else ()
    ):
        if clause.tail.cut(0, place).says({"change", "lane change"}):
            break  # "made an unsafe lane change to the right"
        if _is_no_turn(clause.tail, place) or clause.tail.at(place + 1).is_a("lane") or _is_of_bend(clause, place):
            break
        if item.is_a("hand") and (clause.kind == "turn" or (_is_bare(clause, place))):
            away = (
                clause.lemma in word_set("swerves")
                and place > 1
                and clause.tail.at(place + 1).low not in word_set("turn_targets")
            )
            return Side(item.get("hand")), 0.7 if away else 0.96, Span(clause.span.start, item.span.end)
    for place, item in enumerate(clause.tail.cut(0, 2) if clause.lemma in {"go", "head", "pull"} else ()):
        onto = clause.tail.at(place - 1).low == "the" and clause.tail.at(place + 1).low in {
            "onto",
            "into",
        }  # "to the left onto"
        led = (clause.tail.cut(0, place).says({"the", "from", "to"}) and not onto) or clause.tail.at(
            place + 1
        ).low in word_set("no_turn_after")
        if item.is_a("hand") and not led and clause.kind in {"travel", "emerge"}:
            return Side(item.get("hand")), 0.85, item.span
    if clause.kind == "after":
        return None
    if clause.kind == "intend" and clause.is_passive:
        return None  # "she thought that a left turn was intended"
    items = clause.head if clause.kind in STRIKES | {"see", "drift"} else clause.words
    return next((found for place in range(len(items)) if (found := _noun_turn(clause, items, place))), None)


def _noun_turn(clause: Clause, items: Words, place: int) -> tuple[Side, float, Span] | None:
    """A turn that is a noun, "made a left turn", or the kind of a lane that a vehicle is in."""
    item, after = items[place], items.at(place + 1)
    first = item.low.split()[0]
    hand = _SHORT.get(first, first.title()) if item.get("lanekind") == "turn" else ""
    if item.is_a("hand") and after.low in {"turn", "turning", "turns", "hand turn"}:
        hand, after = item.get("hand"), items.at(place + 2)
    if hand not in {"Left", "Right"} or _is_no_turn(items, place) or after.is_a("curve"):
        return None
    if not after.is_a("lane") and after.low not in {"only", "bay", "pocket"}:
        return (Side(hand), 0.9, item.span) if clause.kind in _MAY_TURN else None
    before = items.cut(0, place)
    counted = any(each.is_a("number", "relative") and each.low not in {"one", "1"} for each in before)
    in_it = before.cut(place - 4).says({"in"}) and clause.kind in _IN_LANE
    return (Side(hand), 0.8, item.span) if in_it and not counted and not items.has("limit") else None


def _is_no_turn(items: Words, place: int) -> bool:
    return items.cut(place, place + 3).says(word_set("not_a_turn")) or items.at(place - 1).low in word_set("hardly")


def _is_of_bend(clause: Clause, place: int) -> bool:
    """Whether it is a road that turns: "a curve, turning right for northbound traffic"."""
    return clause.tail.at(place + 1).low == "for" and clause.sentence.items.has("curve")


def _is_bare(clause: Clause, place: int) -> bool:
    """Whether a hand after "made a" is itself the turn: "making a left onto", "wanted the left at 12th"."""
    after: Item = clause.tail.at(place + 1)
    if clause.lemma == "look":
        return False  # "looked to the left"
    if (clause.kind == "intend" or clause.lemma == "pull") and (
        clause.lemma == "go" or not clause.tail.at(place - 1).is_a("determiner")
    ):
        return False
    return (
        not after.low
        or after.is_a("preposition", "conjunction", "verb", "relative", "bound")
        or after.low in {"turn", ",", ".", "turns"}
    )
