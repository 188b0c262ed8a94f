"""What the vehicles do: turn, stand, change lane, come over the centre line."""

from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Action, Manoeuvre, Side
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, crash_places, of_vehicle, weakened
from roadmend.safe.reading.tokens import Item

_TURNS = {"Left": Action.TURN_LEFT, "Right": Action.TURN_RIGHT}
_REACH = 4  # words between "turn" and "left"
_NOT_A_TURN = frozenset({"wheel", "steering", "head", "signal", "indicator", "blinker", "arrow"})
_STRAIGHT = frozenset({"straight", "through", "thru", "straight ahead", "straight through", "across"})


def read_manoeuvres(text: Text) -> Iterator[Claim]:
    """The claims of a text about actions and manoeuvres."""
    afterwards = crash_places(text.clauses)
    for place, clause in enumerate(text.clauses):
        if clause.subject is None or not clause.subject.vehicles or clause.is_denied:
            continue
        for what, value, confidence, reason, span in _of_clause(clause):
            if afterwards[place] and what == "manoeuvre" and value is Manoeuvre.RUN_OFF:
                continue
            for vehicle in clause.subject.vehicles:
                sure = confidence if clause.subject.span.start >= clause.sentence.span.start else 0.6 * confidence
                yield claim(of_vehicle(vehicle, what), value, weakened(sure, is_after=afterwards[place]), reason, span)
    for row in text.spoken.mentions:
        for mention in row:
            for trait in mention.traits:
                for vehicle in mention.vehicles[:1]:
                    if trait.is_a("parked"):
                        yield claim(
                            of_vehicle(vehicle, "manoeuvre"),
                            Manoeuvre.PARKED,
                            0.9,
                            f"it is called {trait.low}",
                            trait.span,
                        )
                    elif trait.is_a("stationary"):
                        yield claim(
                            of_vehicle(vehicle, "manoeuvre"),
                            Manoeuvre.STOP,
                            0.85,
                            f"it is called {trait.low}",
                            trait.span,
                        )


def _of_clause(clause: Clause) -> Iterator[tuple[str, Action | Manoeuvre, float, str, Span]]:
    turn = turn_of(clause)
    if turn is not None:
        hand, confidence, span = turn
        meant = bool(clause.governed & {"intend"}) or clause.kind in {"intend", "stop"}
        waits = bool(clause.governed & {"stop"}) or clause.kind == "stop"
        confidence = min(confidence, 0.86 if waits else 0.92 if meant else 1.0)
        yield (
            "action",
            _TURNS[hand.value],
            confidence,
            "it is said to turn that way" if not meant else "it is said to mean to turn that way",
            span,
        )
    words = [*clause.head, *clause.tail]
    kind, meant = clause.kind, bool(clause.governed & {"intend", "avoid"})
    if kind in {"continue", "travel", "approach"}:
        straight = next((item for item in clause.tail if item.low in _STRAIGHT or item.is_a("straight")), None)
        if straight is not None and turn is None:
            yield "action", Action.MOVE_FORWARD, 0.85, "it is said to go straight on", straight.span
        elif kind == "continue" or (
            "intend" in clause.governed and any(item.is_a("compass", "bound") for item in clause.tail)
        ):
            yield "straight_on", Action.MOVE_FORWARD, 0.8, "it meant to go on its way", clause.span
    found: tuple[Manoeuvre, float] | None = None
    has = {
        name: any(item.is_a(name) for item in words)
        for name in ("centerline", "wrong", "driveway", "shoulder", "lane", "ramp", "parked", "stationary")
    }
    if kind == "uturn":
        found = Manoeuvre.U_TURN, 0.9
        if True:
            yield "action", Action.TURN_LEFT, 0.9, "a U-turn leads to the left", clause.span
    elif kind == "park" or (kind == "" and has["parked"]):
        found = Manoeuvre.PARKED, 0.9
    elif kind == "reverse":
        found = Manoeuvre.REVERSE, 0.9
    elif kind == "stop" or (
        kind == "" and has["stationary"] and clause.subject is not None and not clause.subject.part
    ):
        found = Manoeuvre.STOP, 0.6 if meant else 0.75
    elif (
        kind in {"drift", "approach", "depart", "travel", "change_lane"} and (has["centerline"] or has["wrong"])
    ) and not clause.is_denied:
        found = Manoeuvre.ENTER_THE_WRONG_WAY, 0.85
    elif kind == "change_lane":
        lemma = clause.verb.lemma if clause.verb is not None else ""
        found = (Manoeuvre.MERGE if lemma in {"merge", "filter", "join"} else Manoeuvre.CHANGING_LANE), 0.8
    elif kind == "overtake":
        found = Manoeuvre.OVERTAKE, 0.7
    elif kind == "emerge" and has["driveway"]:
        found = Manoeuvre.LEAVE_DRIVEWAY, 0.85
    elif kind == "depart" and any(item.is_a("road", "shoulder") for item in words):
        found = Manoeuvre.RUN_OFF, 0.8
    if found is not None and not (meant and kind in {"stop", "drift", "depart"}):
        yield "manoeuvre", found[0], found[1], "the text says so", clause.span


def turn_of(clause: Clause) -> tuple[Side, float, Span] | None:
    """Which way a clause says that its subject turns, how surely, and where it says so."""
    if clause.kind in STRIKES | {"after", "own", "see", "drift"} and clause.kind != "own":
        items = clause.head
    else:
        items = [*clause.head, *clause.tail]
    if clause.kind in {"turn", "do", "change_lane"} or (
        clause.verb is not None and clause.verb.lemma in {"hang", "bear"}
    ):
        for place, item in enumerate(clause.tail[:_REACH]):
            if any(each.low in _NOT_A_TURN for each in clause.tail[place : place + 3]) or (
                clause.tail[place + 1 : place + 2] and clause.tail[place + 1].is_a("lane")
            ):
                break
            if item.is_a("hand") and (clause.kind == "turn" or (clause.kind == "do" and _is_bare(clause.tail, place))):
                return Side(item.kinds["hand"]), 0.96, Span(clause.span.start, item.span.end)
    if clause.kind in {"travel", "emerge"} and clause.verb is not None and clause.verb.lemma in {"go", "head", "pull"}:
        for place, item in enumerate(clause.tail[:2]):
            after = clause.tail[place + 1] if place + 1 < len(clause.tail) else None
            if (
                item.is_a("hand")
                and (after is None or after.low not in {"of", "lane"})
                and not any(each.low in {"the", "from", "to"} for each in clause.tail[:place])
            ):
                return Side(item.kinds["hand"]), 0.85, item.span
    if clause.kind == "after":
        return None
    for place, item in enumerate(items):
        after = items[place + 1] if place + 1 < len(items) else None
        words = item.low.split()
        is_turn = item.kinds.get("lanekind") == "turn" and words[0] in {"left", "right"}
        if item.is_a("hand") and after is not None and after.low in {"turn", "turning", "turns", "hand turn"}:
            is_turn, after, words = (
                True,
                items[place + 2] if place + 2 < len(items) else None,
                [item.kinds["hand"].lower()],
            )
        if not is_turn or any(each.low in _NOT_A_TURN for each in items[place : place + 3]):
            continue
        if after is not None and after.is_a("curve"):
            continue
        if after is not None and (after.is_a("lane") or after.low in {"only", "bay", "pocket"}):
            led = items[place - 1] if place else None
            led_in = any(each.low == "in" for each in items[max(0, place - 4) : place])
            counted = any(
                each.is_a("number", "relative") and each.low not in {"one", "1"} for each in items[:place]
            ) or any(each.is_a("limit") for each in items)
            if (
                led is not None
                and led_in
                and clause.kind in {"travel", "stop", "", "slow", "approach", "intend"}
                and not counted
            ):
                return Side(words[0].title()), 0.8, item.span
            continue
        if clause.kind in {
            "",
            "do",
            "begin",
            "intend",
            "stop",
            "travel",
            "slow",
            "approach",
            "fail",
            "continue",
            "emerge",
        }:
            return Side(words[0].title()), 0.9, item.span
    return None


def _is_bare(items: Sequence[Item], place: int) -> bool:
    """Whether a hand after "made a" is itself the turn: "making a left onto"."""
    after = items[place + 1] if place + 1 < len(items) else None
    return after is None or after.is_a("preposition", "conjunction", "verb") or after.low in {"turn", ",", ".", "turns"}
