"""The shape of the road where the vehicles met: junction, bend, ramp, or none of these; its median and its signs."""

from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Compass, Control, RoadType, Side
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, of_vehicle
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.manoeuvres import turn_of
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.tokens import Item, Words
from roadmend.safe.reading.wording import Wording, found, wording

_SIDES = {"N": Compass.NORTH, "S": Compass.SOUTH, "E": Compass.EAST, "W": Compass.WEST}
_CONTROLS = {"stop_sign": Control.STOP_SIGN, "yield_sign": Control.YIELD_SIGN, "signal": Control.SIGNAL}
_NEAR = 5  # words
_ON_ROAD = frozenset({"", "travel", "approach", "emerge", "turn", "stop", "continue"})
_AT_DRIVEWAY = frozenset({"emerge", "turn", "reverse", "depart", "begin", "travel", "intend", "do"})


def read_roads(text: Text) -> Iterator[Claim]:
    """The claims of a text about its road."""
    for sentence in text.sentences:
        for place, item in enumerate(sentence.items):
            if not sentence.items.cut(place - 2, place).has("negation"):
                yield from _shape(sentence.items, place)
                yield from _order(item)
            yield from _stem(sentence.items, place)
            yield from _corner(sentence.items, place)
    yield from _worded_stem(text)
    yield from _on_stem(text)
    yield from _single_on_stem(text)
    for clause in text.clauses:
        yield from _turns_off(clause, text)


def _shape(items: Words, place: int) -> Iterator[Claim]:
    """Words for junctions and bends."""
    item, before, after = items[place], items.cut(place - _NEAR, place), items.cut(place + 1, place + 5)
    led = {each.low for each in before}
    if item.is_a("junction") and not before.cut(-1).has("ramp") and not items.at(place + 1).is_a("collision"):
        aside = (before.cut(-3).has("compass") and "of" in led) or bool(led & word_set("far_from"))
        comes = any(each.verb is not None and each.verb.kind in {"approach", "turn"} for each in before)
        sure = (0.6 if aside else 0.9) - (0.0 if comes or led & word_set("at_it") else 0.15)
        is_tee = item.get("junction") == "tee"
        kind = RoadType.T_INTERSECTION if is_tee else RoadType.INTERSECTION
        yield claim(
            "road_type", kind, 0.66 if is_tee and aside else 0.96 if is_tee else sure, f"it says {item.low}", item
        )
    elif item.is_a("curve") and not items.at(place + 1).is_a("stop_sign") and items.at(place + 1).low != "warning":
        sure = 0.6 if item.low.endswith("corner") else 0.85  # a corner is more often one of two streets
        yield claim("road_type", RoadType.CURVE, sure, f"the text speaks of a {item.low}", item)
        hand = Words((*reversed(before.cut(len(before) - 3)), *after)).first("hand")
        if hand is not None:
            yield claim("bend", Side(hand.get("hand")), 0.85, "the text says which way the road bends", hand)
    elif item.is_a("straight") and not after.cut(0, 1).has("lane"):
        near = Words((*before.cut(1), *after))
        goes = any(each.verb is not None for each in before.cut(len(before) - 2))
        if (near.has("road", "lane") or near.says({"level", "stretch", "section"})) and not goes:
            yield claim("road_type", RoadType.STRAIGHT, 0.75, "the road is called straight", item)


def _order(item: Item) -> Iterator[Claim]:
    """Words for medians, signs and signals."""
    reason = f"the text speaks of {item.low}"
    if item.is_a("undivided", "divided") or item.get("road") == "divided":
        sure = 0.9 if item.is_a("divided", "undivided") else 0.7
        yield claim("is_divided", not item.is_a("undivided"), sure, reason, item)
    if item.is_a("uncontrolled"):
        yield claim("control", Control.NONE, 0.85, reason, item)
    for name in _CONTROLS if item.low not in word_set("bare_signals") else ():
        if item.is_a(name):
            yield claim("road_type", RoadType.INTERSECTION, 0.62, reason, item)
            yield claim("control", _CONTROLS[name], 0.85, reason, item)


def _stem(items: Words, place: int) -> Iterator[Claim]:
    """A road that ends or crosses, and on which side it lies."""
    item, before = items[place], items.at(place - 1)
    if item.low in {"crosses", "crossed by", "intersects"} and (before.is_a("road", "number") or before.is_name):
        yield claim("road_type", RoadType.INTERSECTION, 0.85, "a road crosses there", item)
    if not (item.low in word_set("joins") or item.is_a("ends") or item.get("junction") == "tee"):
        return
    for ahead in range(place + 1, min(place + 9, len(items))):
        side = _SIDES.get(items[ahead].get("compass") or "")
        if side is not None and items.cut(max(place, ahead - 3), ahead).says({"from", "on"}):
            yield claim("stem_direction", side, 0.85, "the road that ends comes from there", items[ahead])
            span = Span(item.span.start, items[ahead].span.end)
            yield claim("road_type", RoadType.T_INTERSECTION, 0.85, "a road joins from one side", span)
            break
    near, meets = items.cut(place - 6, place), item.low.startswith(("stops", "meets", "joins"))
    is_it = before.low == "it" and any(each.is_name and not each.kinds for each in items.cut(1, place))
    ends = item.is_a("ends") and not meets and (near.has("road") or any(each.is_name for each in near) or is_it)
    if ends or (item.low in {"ends", "ends there"} and items.cut(0, place).has("road")):
        yield claim("road_type", RoadType.T_INTERSECTION, 0.85, "a road ends there", item)


def _worded_stem(text: Text) -> Iterator[Claim]:
    """A road that goes no further, by a turn of phrase, and the side on which the text says that it lies."""
    told = [wording(sentence) for sentence in text.sentences]
    ending = [
        any(_is_of_road(each, match.start(), mentions) for match in found("stem_ends", each))
        for each, mentions in zip(told, text.spoken.mentions, strict=True)
    ]
    tees = [
        each.items.has("ends") or any(i.low == "ends" or i.get("junction") == "tee" for i in each.items)
        for each in told
    ]
    said_tee = any(tees)
    for place, each in enumerate(told):
        near = any(ending[max(0, place - 1) : place + 2]) or tees[place]
        if ending[place]:
            yield claim(
                "road_type", RoadType.T_INTERSECTION, 0.85, "a road goes no further", text.sentences[place].span
            )
        for match in found("stem_side", each) if near or (said_tee and not each.items.has("mph")) else ():
            if (each.items.has("collision") and not ending[place]) or (text.spoken.mentions[place] and not near):
                continue
            side = _SIDES.get(match[1][0].upper())
            yield claim("stem_direction", side, 0.8 if near else 0.6, "the road that ends lies there", each.span(match))
        before = [clause for clause in text.clauses if clause.sentence.index <= place and clause.subject.vehicles]
        for match in found("stem_hand", each) if near and before else ():
            who, hand = before[0].subject.vehicles[0], Side(match[1].title())
            yield claim(
                of_vehicle(who, "stem_hand"), hand, 0.8, "the road that ends lies on that hand", each.span(match)
            )


def _is_of_road(told: Wording, letter: int, mentions: Sequence[Mention]) -> bool:
    """Whether it is a road that ends there, and no vehicle, lane or ramp."""
    at, before = told.item(letter), told.items.cut(0, told.item(letter))
    part = before.cut(max((place + 1 for place, each in enumerate(before) if each.low == ";"), default=0))
    things = {MentionKind.IT, MentionKind.POSSESSIVE}  # "it", "its last mile": of the road, as likely as not
    vehicle = max((each.last for each in mentions if each.last < at and each.kind not in things), default=-1)
    named = (
        place
        for place, each in enumerate(before)
        if each.is_a("road") or (each.is_name and (each.is_a("lane") or not each.kinds))
    )
    road = max(named, default=-1)
    pronoun = not mentions and not part.has("ramp", "lane")
    near = part.cut(len(part) - 4)
    of_lane = near.has("ramp") or any(each.is_a("lane") and not each.is_name for each in near)
    return not of_lane and (road > vehicle or pronoun or part.at(0).low == "it")


def _corner(items: Words, place: int) -> Iterator[Claim]:
    """Two roads named together: "at Ninth and Colfax", "the corner of Oak and Pine"."""
    item, names = items[place], items.cut(place + 1, place + 8)
    joint = next((at for at, each in enumerate(names.cut(0, 4)) if each.low in {"and", "/", "&"}), 0)
    if not (item.low == "at" or item.is_a("corner")) or not joint:
        return
    one, other = names.cut(0, joint), names.at(joint + 1)
    proper = all(each.is_name or each.is_a("ordinal", "road", "number", "compass") for each in one)
    if proper and (other.is_name or other.is_a("ordinal")) and not other.is_a("thing", "name", "body"):
        span = Span(item.span.start, other.span.end)
        yield claim("road_type", RoadType.INTERSECTION, 0.85, "two roads are named together", span)


def _on_stem(text: Text) -> Iterator[Claim]:
    """Vehicles that come along the road that ends at a T, or cross the road that goes through."""
    ending: set[str] = set()
    for sentence in text.sentences:
        for place, item in enumerate(sentence.items):
            near = sentence.items.cut(place - 3, place)
            names = [each for each in near if each.is_name and not each.is_a("determiner", "road", "pronoun", "lane")]
            start = sentence.items.cut(0, 3)
            if not names and start.at(0).is_name and start.cut(1).has("road"):
                names = [each for each in start if each.is_name and not each.is_a("determiner", "road", "lane")]
            if names and (item.is_a("ends") or item.low in {"ends", "dead ends", "joins", "comes in"}):
                ending.add(names[-1].low)
    for clause in text.clauses:
        words = clause.words
        for place, item in enumerate(words if clause.kind in _ON_ROAD and len(clause.subject.vehicles) == 1 else ()):
            led = words.cut(place - 2, place).says(word_set("along"))
            ends = item.is_a("ends") and item.low.startswith(("ends", "ended", "dead", "terminates"))
            crosses = item.is_a("axis") and clause.kind == "approach" and clause.lemma in {"cross", "travel", "go"}
            sure = 0.85 if item.low in word_set("minor_roads") and clause.kind in {"emerge", "turn"} and led else 0.0
            if item.low in ending and led:
                sure = 0.9
            elif ends and words.cut(0, place).has("road", "relative"):
                sure = 0.85
            elif (
                item.low == "across"
                and words.cut(place, place + 6).has("road")
                and clause.kind in {"continue", "travel"}
            ):
                sure = 0.7
            elif crosses and words.cut(place, place + 3).has("lane", "road"):
                sure = 0.75
            if sure:
                reason = "it comes along the road that ends, or crosses the one that goes through"
                yield claim(
                    of_vehicle(clause.subject.vehicles[0], "on_stem"),
                    value=True,
                    confidence=sure,
                    reason=reason,
                    where=item,
                )


def _single_on_stem(text: Text) -> Iterator[Claim]:
    """Who stops at a sign of a T comes along its stem; so does who runs off at the end of a road, alone."""
    for clause in text.clauses:
        signed = clause.words.first("stop_sign", "yield_sign")
        heeds = clause.kind not in STRIKES | {"see", "say", "after", "collide"} and clause.is_real
        if heeds and signed is not None and len(clause.subject.vehicles) == 1:
            path = of_vehicle(clause.subject.vehicles[0], "on_stem")
            yield claim(path, value=True, confidence=0.75, reason="it stops at the sign", where=signed)
    if text.count == 1:
        yield claim(of_vehicle(0, "on_stem"), value=True, confidence=0.75, reason="it is alone", where=None)


def _turns_off(clause: Clause, text: Text) -> Iterator[Claim]:
    """Who turns into another road, and who comes out of a driveway or turns into one."""
    words, kind = clause.words, clause.kind
    if not clause.subject.vehicles:
        return
    out = {vehicle for each in text.clauses if each.words.has("driveway") for vehicle in each.subject.vehicles}
    onto = kind == "travel" and words.says({"onto", "on to"})
    for place, item in enumerate(words[:-1] if kind in {"turn", "do", "begin", "intend"} or onto else ()):
        ahead = words.cut(place + 1, place + 4)
        to_road = ahead[0].is_name or any(each.is_a("road") and each.low != "place" for each in ahead)
        turns = (
            kind == "turn" or (onto and item.low in {"onto", "on to"}) or words.cut(0, place).has("hand", "lanekind")
        )
        if (
            item.low in word_set("turn_targets") | {"toward", "towards"}
            and to_road
            and turns
            and not out & {*clause.subject.vehicles}
        ):
            yield claim("road_type", RoadType.INTERSECTION, 0.75, "a vehicle turns into another road", item)
            break
    items = clause.sentence.items
    for place, item in enumerate(items[:-1] if turn_of(clause) is not None and not out else ()):
        after = items[place + 1]
        named = (after.is_name and not after.is_a("thing", "body", "name", "time", "determiner")) or after.low[
            0
        ].isdigit()
        if (
            item.low in {"at", "on", "onto", "into"}
            and after.is_a("ordinal")
            and not items.at(place + 2).is_a("lane", "body")
        ):
            named = True
        elif item.low != "at":
            continue
        if named and not items.at(place + 2).is_a("mph", "time"):
            yield claim("road_type", RoadType.INTERSECTION, 0.72, "a vehicle turns at another road", item)
            break
    drive = words.first("driveway")
    if drive is not None and kind in _AT_DRIVEWAY:
        place = words.index(drive)
        led = words.cut(place - 4, place).says(word_set("driveway_leads"))
        if led or (kind in {"emerge", "depart"} and place < 4):
            yield claim("driveway", value=True, confidence=0.8, reason="a vehicle uses a driveway", where=drive)
