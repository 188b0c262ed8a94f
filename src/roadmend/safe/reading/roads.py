"""The shape of the road where the vehicles met: junction, bend, ramp, or none of these; its median and its signs."""

from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Compass, Control, RoadType, Side
from roadmend.safe.reading.facts import Text, claim
from roadmend.safe.reading.tokens import Item

_SIDES = {"N": Compass.NORTH, "S": Compass.SOUTH, "E": Compass.EAST, "W": Compass.WEST}
_FAR = frozenset(
    {
        "near",
        "past",
        "beyond",
        "after",
        "from",
        "of",
        "toward",
        "towards",
        "feet",
        "meters",
        "metres",
        "yards",
        "miles",
        "km",
        "adjacent",
        "next",
        "until",
    }
)
_AT_IT = frozenset(
    {
        "at",
        "in",
        "into",
        "through",
        "within",
        "entered",
        "enter",
        "entering",
        "approaching",
        "approached",
        "crossing",
        "cross",
    }
)
_NEAR = 5  # words


def read_roads(text: Text) -> Iterator[Claim]:
    """The claims of a text about its road."""
    for sentence in text.sentences:
        items = sentence.items
        for place, item in enumerate(items):
            yield from _of_word(items, place, item)
        yield from _stems(items)
        yield from _corner(items)
    yield from _of_clauses(text)
    yield from _on_stem(text)


def _of_word(items: Sequence[Item], place: int, item: Item) -> Iterator[Claim]:
    before, after = items[max(0, place - _NEAR) : place], items[place + 1 : place + 1 + _NEAR]
    denied = any(each.is_a("negation") or each.low in {"no", "not"} for each in before[-2:])
    if item.is_a("junction") and not denied and not (before and before[-1].is_a("ramp")):
        is_tee = item.kinds["junction"] == "tee"
        led = {each.low for each in before[-4:]}
        distant = (any(each.is_a("compass") for each in before[-3:]) and "of" in led) or bool(
            led & {"feet", "meters", "metres", "yards", "adjacent", "prior", "past", "next", "before", "after"}
        )
        weight = 0.6 if distant else 0.9
        if is_tee:
            yield claim(
                "road_type", RoadType.T_INTERSECTION, weight + 0.06, f"the text speaks of a {item.low}", item.span
            )
        else:
            at_it = led & _AT_IT or any(
                each.verb is not None and each.verb.kind in {"approach", "turn"} for each in before
            )
            yield claim(
                "road_type",
                RoadType.INTERSECTION,
                weight if at_it else weight - 0.15,
                f"the text speaks of an {item.low}",
                item.span,
            )
    elif item.is_a("curve") and not denied and not item.is_a("junction"):
        if not any(each.is_a("stop_sign") or each.low in {"warning", "airbag", "airbags"} for each in after[:1]):
            yield claim("road_type", RoadType.CURVE, 0.85, f"the text speaks of a {item.low}", item.span)
            hand = next((each for each in [*reversed(before[-3:]), *after[:4]] if each.is_a("hand")), None)
            if hand is not None:
                yield claim("bend", Side(hand.kinds["hand"]), 0.85, "the text says which way the road bends", hand.span)
    elif item.is_a("straight") and not denied:
        road_near = any(
            each.is_a("road", "lane") or each.low in {"level", "stretch", "section"}
            for each in [*before[-4:], *after[:4]]
        )
        goes = any(each.verb is not None for each in before[-2:])
        if road_near and not goes and not (after and after[0].is_a("lane")):
            yield claim("road_type", RoadType.STRAIGHT, 0.75, "the road is called straight", item.span)
    if item.is_a("undivided"):
        yield claim("is_divided", value=False, confidence=0.9, reason=f"the text says {item.low}", where=item.span)
    elif (item.is_a("divided") or item.kinds.get("road") == "divided") and not denied:
        yield claim(
            "is_divided",
            value=True,
            confidence=0.9 if item.is_a("divided") else 0.7,
            reason=f"the text says {item.low}",
            where=item.span,
        )
    if (
        item.is_a("signal", "stop_sign", "yield_sign")
        and not denied
        and item.low not in {"signal", "lights", "signals", "signaled"}
    ):
        yield claim("road_type", RoadType.INTERSECTION, 0.62, f"the text speaks of a {item.low}", item.span)
    for name, control in (
        ("stop_sign", Control.STOP_SIGN),
        ("yield_sign", Control.YIELD_SIGN),
        ("signal", Control.SIGNAL),
        ("uncontrolled", Control.NONE),
    ):
        if item.is_a(name) and not denied and item.low not in {"signal", "lights", "signals"}:
            yield claim("control", control, 0.85, f"the text speaks of a {item.low}", item.span)


def _stems(items: Sequence[Item]) -> Iterator[Claim]:
    """A road that ends, and on which side it lies."""
    for place, item in enumerate(items):
        if (
            item.low in {"crosses", "crossed by", "intersects"}
            and place
            and (items[place - 1].is_a("road", "number") or items[place - 1].text[:1].isupper())
        ):
            yield claim("road_type", RoadType.INTERSECTION, 0.85, "a road crosses there", item.span)
        verb = (
            item.low
            in {
                "joins",
                "comes in",
                "meets",
                "enters",
                "ends",
                "tees",
                "joining",
                "dead ends",
                "intersects",
                "met",
                "joined",
                "comes",
                "terminates",
                "branches",
            }
            or item.is_a("ends")
            or item.kinds.get("junction") == "tee"
        )
        if not verb:
            continue
        for ahead in range(place + 1, min(place + 9, len(items))):
            side = _SIDES.get(items[ahead].kinds.get("compass", ""))
            led = {each.low for each in items[max(place, ahead - 3) : ahead]}
            if side is not None and led & {"from", "on"}:
                yield claim("stem_direction", side, 0.85, "the road that ends comes from there", items[ahead].span)
                yield claim(
                    "road_type",
                    RoadType.T_INTERSECTION,
                    0.85,
                    "a road joins from one side",
                    Span(item.span.start, items[ahead].span.end),
                )
                break
        if (
            item.is_a("ends")
            and not item.low.startswith(("stops", "meets", "joins"))
            and any(each.is_a("road") or each.text[:1].isupper() for each in items[max(0, place - 6) : place])
        ):
            yield claim("road_type", RoadType.T_INTERSECTION, 0.85, "a road ends there", item.span)
        if item.low in {"ends", "ends there"} and any(each.is_a("road") for each in items[:place]):
            yield claim("road_type", RoadType.T_INTERSECTION, 0.8, "a road ends there", item.span)


def _on_stem(text: Text) -> Iterator[Claim]:
    """Vehicles that come along the road that ends at a T, or cross the road that goes through."""
    ending: dict[str, Span] = {}
    for sentence in text.sentences:
        for place, item in enumerate(sentence.items):
            if item.is_a("ends") or item.low in {"ends", "dead ends", "joins", "comes in"}:
                near = sentence.items[max(0, place - 3) : place]
                name = next(
                    (
                        each
                        for each in reversed(near)
                        if each.text[:1].isupper() and not each.is_a("determiner", "road", "pronoun")
                    ),
                    None,
                )
                if name is not None:
                    ending[name.low] = item.span
    for clause in text.clauses:
        if (
            clause.subject is None
            or len(clause.subject.vehicles) != 1
            or clause.kind not in {"", "travel", "approach", "emerge", "turn", "stop"}
        ):
            continue
        path = f"vehicles[{clause.subject.vehicles[0]}].on_stem"
        words = [*clause.head, *clause.tail]
        for place, item in enumerate(words):
            led = any(
                each.low in {"on", "along", "down", "of", "off", "from"} for each in words[max(0, place - 2) : place]
            )
            if item.low in ending and led:
                yield claim(
                    path, value=True, confidence=0.9, reason="it comes along the road that ends there", where=item.span
                )
            elif (
                item.is_a("ends")
                and item.low.startswith(("ends", "ended", "dead", "terminates"))
                and any(each.is_a("road", "relative") for each in words[:place])
            ):
                yield claim(
                    path, value=True, confidence=0.85, reason="it comes along a road that ends", where=item.span
                )
            elif (
                item.is_a("axis")
                and clause.kind == "approach"
                and clause.verb is not None
                and clause.verb.lemma in {"cross", "travel", "go"}
                and any(each.is_a("lane", "road") for each in words[place : place + 3])
            ):
                yield claim(
                    path, value=True, confidence=0.75, reason="it crosses the road that goes through", where=item.span
                )


def _corner(items: Sequence[Item]) -> Iterator[Claim]:
    """Two roads named together: "at Ninth and Colfax", "the corner of Oak and Pine"."""
    for place, item in enumerate(items):
        if not (item.low == "at" or item.is_a("corner")) or place + 3 >= len(items):
            continue
        names = list(items[place + 1 : place + 8])
        joint = next((at for at, each in enumerate(names) if each.low in {"and", "/", "&"}), None)
        if joint is None or joint == 0 or joint > 3 or joint + 1 >= len(names):
            continue
        one, other = names[:joint], names[joint + 1]
        proper = all(each.text[:1].isupper() or each.is_a("ordinal", "road", "number", "compass") for each in one) and (
            other.text[:1].isupper() or other.is_a("ordinal")
        )
        if proper and not other.is_a("thing", "name", "body"):
            yield claim(
                "road_type",
                RoadType.INTERSECTION,
                0.85,
                "two roads are named together",
                Span(item.span.start, other.span.end),
            )


def _of_clauses(text: Text) -> Iterator[Claim]:
    ramps: dict[int, tuple[float, Span]] = {}
    for clause in text.clauses:
        if clause.subject is None or not clause.subject.vehicles or clause.kind == "after":
            continue
        words = [*clause.head, *clause.tail]
        ramp = next((item for item in words if item.is_a("ramp")), None)
        joins = clause.kind in {
            "change_lane",
            "approach",
            "emerge",
            "travel",
            "",
            "intend",
            "drift",
            "begin",
            "turn",
            "do",
        }
        if ramp is not None and joins and ramp.kinds["ramp"] != "off":
            place = words.index(ramp)
            led = {each.low for each in words[max(0, place - 5) : place]}
            enters = bool(led & {"onto", "into", "toward", "towards", "to"}) and not led & {"from", "on", "along", "of"}
            from_it = bool(led & {"from", "on", "along", "by", "via", "down", "using"}) or (
                not enters and "lane" in led
            )
            enters |= clause.kind == "approach" and not from_it
            weight = 0.35 if enters else 0.9 if ramp.kinds["ramp"] == "on" else 0.75
            for vehicle in clause.subject.vehicles[:1]:
                if weight > ramps.get(vehicle, (0.0, clause.span))[0]:
                    ramps[vehicle] = weight, ramp.span
    merges = any(
        (clause.kind == "change_lane" and clause.verb is not None and clause.verb.lemma in {"merge", "join"})
        or any(item.is_a("ramp") and item.kinds["ramp"] == "on" for item in clause.tail)
        for clause in text.clauses
    )
    for vehicle, (weight, span) in ramps.items():
        yield claim(
            f"vehicles[{vehicle}].on_ramp", value=True, confidence=weight, reason="it comes from a ramp", where=span
        )
        if weight > 0.5:
            yield claim(
                "road_type", RoadType.MERGING, weight if merges else weight - 0.2, "a vehicle joins from a ramp", span
            )
    for clause in text.clauses:
        if clause.subject is None or not clause.subject.vehicles:
            continue
        words = [*clause.head, *clause.tail]
        out = {
            vehicle
            for each in text.clauses
            if each.subject is not None and any(item.is_a("driveway") for item in [*each.head, *each.tail])
            for vehicle in each.subject.vehicles
        }
        if clause.kind in {"turn", "do", "begin", "intend"} and not out & {*clause.subject.vehicles}:
            for place, item in enumerate(words[:-1]):
                if (
                    item.low in {"onto", "into", "on to", "down", "to"}
                    and (
                        words[place + 1].text[:1].isupper()
                        or any(each.is_a("road") for each in words[place + 1 : place + 4])
                    )
                    and (clause.kind == "turn" or any(each.is_a("hand", "lanekind") for each in words[:place]))
                ):
                    yield claim(
                        "road_type", RoadType.INTERSECTION, 0.75, "a vehicle turns into another road", item.span
                    )
                    break
        drive = next((item for item in [*clause.head, *clause.tail] if item.is_a("driveway")), None)
        if drive is None or clause.kind not in {
            "emerge",
            "turn",
            "reverse",
            "depart",
            "begin",
            "travel",
            "intend",
            "do",
        }:
            continue
        place = words.index(drive)
        led = {each.low for each in words[max(0, place - 4) : place]}
        if led & {"from", "of", "into", "to", "out of", "onto"} or (clause.kind in {"emerge", "depart"} and place < 4):
            yield claim(
                "driveway",
                value=True,
                confidence=0.8,
                reason="a vehicle comes from or turns into a driveway",
                where=drive.span,
            )
