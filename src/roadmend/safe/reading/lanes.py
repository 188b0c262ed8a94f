"""How many lanes the road has, both directions together; at a junction, the larger road."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import MAX_LANES
from roadmend.safe.reading.facts import Text, claim
from roadmend.safe.reading.tokens import Item, Sentence, Words
from roadmend.safe.reading.wording import Wording, found, number_of, patterns, wording

_REACH = 6  # words between a number and its "lanes"
_MOST_COUNTED = 12
_LIST = 12  # characters between two counts of one list
_BETWEEN = ("lanekind", "bound", "compass", "hand", "descriptor", "straight", "two_way")
_PART = re.compile(r"[,;(]| and | with ")
_OVER_HERE = re.compile(r"\b(?:this|that|our|my|his|her) (?:side|way|direction|half)\b", re.IGNORECASE)
_OVER_THERE = re.compile(
    r"\b(?:other|opposite|opposing|oncoming|far) (?:side|way|direction|half|carriageway|traffic|lanes)\b", re.IGNORECASE
)
_SIDE = re.compile(
    r"\b(?:(?P<there>(?:other|opposite|opposing|oncoming|far|return) ?(?:side|way|direction|half|carriageway|traffic|lanes)?|"
    r"back|theirs|against (?:me|us|him|her|them)|"
    r"(?:over|beyond|across|past|behind) the (?:wall|barrier|median|divider|guard ?rail|cable|grass|center|centre|yellow|line))|"
    r"(?P<here>(?:this|that|our|my|his|her|their|near|same) (?:own )?(?:side|way|direction|half|carriageway)|ours|mine)|"
    r"(?P<way>(?<!/)(?<!/ )(?:(?:north|south|east|west)(?:bound|ward|wards)?|[nsew]b)(?! ?/)))\b"
)
_BACK = {"N": "S", "S": "N", "E": "W", "W": "E"}
_OPPOSITE = ({"N", "S"}, {"E", "W"})
_EACH, _ALL = "the text counts the lanes of each direction", "the text counts the lanes of the road"
_Total = tuple[int, float, str, Span]  # lanes, confidence, reason, place


@dataclass(frozen=True, slots=True)
class LaneCount:
    """Lanes that a text counts.

    Attributes:
        number: of them.
        way: "N", "S", "E", "W", or "NS", "EW" for both directions; empty where it is not said.
        kind: "road" for those of the whole road ("a two-lane road"), "turn" and "center" for turning, "travel", "other".
        is_each: whether each direction has so many.
        span: in the summary.
        sentence: its number.
    """

    number: int
    way: str
    kind: str
    is_each: bool
    span: Span
    sentence: int


def read_lanes(text: Text) -> Iterator[Claim]:
    """The claims of a text about the number of its lanes; the largest road of a place counts."""
    worded = [each for sentence in text.sentences for each in _worded(sentence)]
    # What a count in front of "lanes" says is left to the grammar of counts, too: it knows more of turning lanes.
    taken = [
        span
        for *_, reason, span in worded
        if reason != _EACH or " lane" not in text.summary[span.start : span.end].lower()
    ]
    counts = _shared([count for sentence in text.sentences for count in _of_sentence(sentence)])
    counts = [
        count
        for count in counts
        if not any(count.span.start < span.end and span.start < count.span.end for span in taken)
    ]
    for sentence in text.sentences:
        known = any(each.kind == "center" and each.sentence == sentence.index for each in counts)
        if sentence.items.has("middle_lane") and not known:
            counts.append(LaneCount(1, "", "center", is_each=False, span=Span(0, 0), sentence=sentence.index))
    mirrored = [each for each in text.sentences if any(found("lanes_mirrored", wording(each)))]
    counts = list(_sided(counts, text))
    totals = [total for count in counts if (total := _total(counts, count)) is not None]
    totals = [*worded, *totals, *(() if taken else _by_way(counts, is_mirrored=bool(mirrored)))] or _bare(
        counts, text, mirrored
    )
    largest = max((number for number, *_ in totals), default=0)
    for number, sure, reason, span in totals:
        if 1 <= number <= MAX_LANES:
            yield claim("num_lanes", number, sure if number == largest else min(sure, 0.3), reason, span)
    if not totals:
        yield from _implied(text)


def _worded(sentence: Sentence) -> Iterator[_Total]:
    """Lanes that a turn of phrase counts: "two up and two down", "one each way", "four lanes in all"."""
    told, taken = wording(sentence), list[Span]()
    has_middle = any(pattern.search(told.text) for pattern in patterns("lanes_middle"))
    speaks = sentence.items.has("lane", "divided") or "laner" in told.text or "carriageway" in told.text
    speaks |= sentence.items.has("road", "each")
    for name in ("lanes_road", "lanes_sum", "lanes_each"):
        for match in found(name, told) if speaks else ():
            span = told.span(match)
            if any(span.start < each.end and each.start < span.end for each in taken):
                continue
            total = sum(map(int, match.groups())) * (2 if name == "lanes_each" else 1)
            if total > MAX_LANES or (name == "lanes_road" and total == 1 and "wide" not in match[0]):
                continue
            taken.append(span)
            reason = _EACH if name == "lanes_each" else _ALL
            yield total + (has_middle and total % 2 == 0 and name != "lanes_road"), 0.94, reason, span
    two_sides = _of_two_sides(told) if speaks and not taken and not _is_counted(sentence) else None
    if two_sides is not None:
        taken.append(two_sides[1])
        yield two_sides[0] + (has_middle and two_sides[0] % 2 == 0), 0.9, _ALL, two_sides[1]
    if not taken and any(found("lanes_both", told)):
        yield 2, 0.6, "the text speaks of both lanes", sentence.span


def _is_counted(sentence: Sentence) -> bool:
    """Whether what is counted in front of "lanes" says it all, turning lanes too: those of two opposite directions."""
    ways = {each.way for each in _of_sentence(sentence)}
    return any({*axis} <= ways for axis in ("NS", "EW"))


def _of_two_sides(told: Wording) -> tuple[int, Span] | None:
    """Lanes of a road of which each side is counted for itself: "three on this side, the other side also has three"."""
    lanes: dict[str, int] = {}  # by side, in the order of the text
    counts = [match for pattern in patterns("lanes_counted") for match in pattern.finditer(told.text)]
    for place, count in enumerate(counts):
        begin = counts[place - 1].end() if place else 0
        end = counts[place + 1].start() if place + 1 < len(counts) else len(told.text)
        after = _PART.split(told.text[count.end() : end])[0]
        side = _SIDE.search(after) or _SIDE.search(_PART.split(told.text[begin : count.start()])[-1])
        name = "" if side is None else side["way"][0] if side["way"] else str(side.lastgroup)
        lanes.setdefault(name, int(count[1]))
    if len(counts) == 2 and [*lanes] == ["", "there"]:
        lanes["here"] = lanes.pop("")  # "two lanes, and two more on the other side"
    for one, other in (("here", "there"), ("n", "s"), ("e", "w")):
        if one in lanes and other in lanes and lanes[one] + lanes[other] <= MAX_LANES:
            first, last = counts[0].start(), counts[-1].end() - 1
            return lanes[one] + lanes[other], told.items.span(told.item(first), told.item(last))
    return None


def _sided(counts: Sequence[LaneCount], text: Text) -> Iterator[LaneCount]:
    """Give the lanes of "this side" and of "the other side" the directions that the text names."""
    known = next((each.way for each in counts if len(each.way) == 1), "")
    for count in counts:
        sentence = text.sentences[count.sentence]
        if count.way or count.is_each or count.kind != "travel" or not count.span.end:
            yield count
            continue
        around = _PART.split(text.summary[sentence.span.start : count.span.start])[-1]
        around += _PART.split(text.summary[count.span.start : sentence.span.end])[0]
        here = next((each.get("bound") for each in sentence.items if len(each.get("bound") or "") == 1), "")
        if _OVER_THERE.search(around):
            yield replace(count, way=_BACK.get(known, "S"))
        elif _OVER_HERE.search(around):
            yield replace(count, way=here or _BACK.get(known, "N"))
        else:
            yield count


def _shared(counts: Sequence[LaneCount]) -> list[LaneCount]:
    """Let "each direction" hold for what is listed before it: "two through lanes and a turn lane for each direction"."""
    shared = list(counts)
    for place in range(len(shared) - 1, 0, -1):
        one, other = shared[place - 1], shared[place]
        near = one.sentence == other.sentence and other.span.start - one.span.end < _LIST
        if other.is_each and near and one.kind != other.kind and one.kind in {"travel", "turn"} and len(one.way) != 1:
            shared[place - 1] = replace(one, is_each=True)
    return shared


def _total(counts: Sequence[LaneCount], count: LaneCount) -> _Total | None:
    """The lanes of a road, where one count gives them."""
    here = [each for each in counts if each.sentence == count.sentence]
    if count.kind == "road":  # a road with a lane for turning between the directions has an odd number
        middle = any(each.kind == "center" for each in here) and count.number % 2 == 0
        return count.number + middle, 0.93, "the text counts the lanes of the road", count.span
    if count.is_each and count.kind == "travel":
        near = [
            each for each in counts if abs(each.sentence - count.sentence) <= 1 and not each.way and not each.is_each
        ]
        own = next((each for each in near if each.kind in {"center", "turn"}), None)
        extra = own.number if own is not None and (own.kind == "center" or own in here) else 0
        extra += 2 * sum(each.number for each in here if each.is_each and each.kind == "turn")
        return 2 * count.number + extra, 0.92, "the text counts the lanes of each direction", count.span
    if len(count.way) == 2 and count.kind == "travel":
        return count.number, 0.75, "the text counts the lanes of both directions", count.span
    return None


def _by_way(counts: Sequence[LaneCount], *, is_mirrored: bool) -> Iterator[_Total]:
    """Roads whose lanes are counted for each direction apart: "three northbound and two southbound lanes"."""
    for axis in ("NS", "EW"):
        mine = [each for each in counts if len(each.way) == 1 and each.way in axis and not each.is_each]
        sums = [total for way in axis if (total := _of_way([each for each in mine if each.way == way]))]
        if len(sums) == 1 and is_mirrored:
            yield 2 * sums[0], 0.85, "the other direction has as many lanes", mine[0].span
        elif len(sums) == 1:
            one = 2 if sums[0] == 1 else sums[0]
            yield one, 0.6, "the text counts the lanes of one direction alone", mine[0].span
        elif sums:
            shared = [each for each in counts if not each.way and 0 <= each.sentence - mine[0].sentence <= 1]
            extra = sum(e.number for e in shared if e.kind == "center" or (e.kind == "turn" and e.number == 1))
            yield sum(sums) + extra, 0.9, "the text counts the lanes of both directions", mine[0].span


def _of_way(counts: Sequence[LaneCount]) -> int:
    """The lanes of one direction: the general count with what is added to it, or the kinds that make it up."""
    plain = [each for each in counts if each.kind == "travel"]
    turning = [each for each in counts if each.kind in {"turn", "center"}]
    if not plain:
        return sum(each.number for each in turning)
    general = max(plain, key=lambda each: each.number)
    rest = sum(each.number for each in plain if each is not general and each.sentence == general.sentence)
    if general.number > 1 and rest + sum(each.number for each in turning) == general.number:
        return general.number  # the kinds spell the general count out
    return general.number + sum(each.number for each in turning if each.sentence == general.sentence)


def _bare(counts: Sequence[LaneCount], text: Text, mirrored: Sequence[Sentence]) -> list[_Total]:
    plain = [each for each in counts if each.kind == "travel" and not each.way]
    if not plain:
        return []
    most = max(plain, key=lambda each: each.number)
    if most.number == 1:
        total = 1 if any(sentence.items.has("one_way") for sentence in text.sentences) else 2
    else:
        near = [each for each in counts if not each.way and each.sentence == most.sentence and each.span.end]
        total = most.number + sum(each.number for each in near if each.kind in {"turn", "center"})
    if any(number_of(item) == most.number for each in mirrored for item in each.items):
        return [(2 * total, 0.8, "the other direction has as many lanes", most.span)]
    return [(total, 0.55, "the text counts lanes and does not say of which direction", most.span)]


def _of_sentence(sentence: Sentence) -> Iterator[LaneCount]:
    items = sentence.items
    for place, item in enumerate(items):
        number, after = number_of(item), items.at(place + 1)
        if item.low in {"a", "an"}:  # "a lane each way", "a center turn lane"
            is_each = after.is_a("lane") and items.at(place + 2).is_a("each")
            near = items.cut(place + 1, place + 4)
            is_center = any(each.get("lanekind") == "center" for each in near.cut(0, 2)) and near.has("lane")
            number = 1 if is_each or is_center else None
        if items.at(place - 1).low in {"#", "number"}:
            number = None  # "in #2 lane"
        if isinstance(number, int) and 1 <= number <= _MOST_COUNTED and not item.is_a("time"):
            lane = _lane_after(items, place)
            if lane is not None:
                yield _count(items, place, lane, number, sentence.index)


def _lane_after(items: Words, place: int) -> int | None:
    for at in range(place + 1, min(place + 1 + _REACH, len(items))):
        item = items[at]
        if item.is_a("lane"):
            return at
        listed = item.low in {"and", ","} and items.at(at + 1).is_a("number")
        both = item.is_a("number", "bound") and items.cut(place + 1, at).has("bound")
        plain = item.is_a(*_BETWEEN) or not item.kinds or item.low in {"and", "only"}
        if item.low in {"ft", "feet", "foot", "m", "meters", "metres", "car", "cars"}:
            return None
        if not (listed or both or plain) or (not listed and (item.low in ".,;:()%" or item.is_a("mph"))):
            return None
    return None


def _count(items: Words, place: int, lane: int, number: int, sentence: int) -> LaneCount:
    between = items.cut(place + 1, lane)
    ands = [at for at, each in enumerate(between) if each.low == "and" and between.cut(at).has("number")]
    own = between.cut(0, ands[0] if ands else None)
    kinds = {each.get("lanekind") for each in own}
    kind = next((each for each in ("other", "center", "turn") if each in kinds), "travel")
    way = next((w for e in own if len(w := e.get("bound") or e.get("compass") or "") == 1), "")
    is_each, road = _is_each(items, lane, place), items.cut(place - 6, place)
    if not way:
        way, both = _way_after(items, lane)
        is_each |= both
    led = road.cut(len(road) - 3).says({"has", "have", "had", "with"}) and (
        road.has("road") or any(e.is_name for e in road)
    )
    of_road = items[lane].low in {"lane", "ln", "lande"} or (led and not _way_of_sentence(items, place))
    is_single = place + 1 == lane and items.cut(lane + 1, lane + 4).has("road") and items[lane].low == "lane"
    if of_road and (number > 1 or is_single) and not is_each and not way and kind == "travel":
        kind = "road"
    elif not way and kind != "other":
        way = _way_of_sentence(items, place)
    return LaneCount(number, way, kind, is_each=is_each, span=items.span(place, lane), sentence=sentence)


def _way_after(items: Words, lane: int) -> tuple[str, bool]:
    """The direction that is named after "lanes", and whether both are: "two lanes westbound and two eastbound"."""
    after = items.cut(lane + 1, lane + 9)
    for at, item in enumerate(after.cut(0, 4)):
        if item.low in ",;" or item.is_a("number"):
            break
        heads = item.is_a("compass") and after.at(at - 1).low in {"for", "heading", "going", "traveling"}
        if item.is_a("bound", "axis") or heads or (at == 0 and item.is_a("compass")):
            both = {each.get("bound") for each in after.cut(at, at + 4)} - {None}
            return item.get("axis") or item.get("bound") or item.get("compass") or "", both in _OPPOSITE
    return "", False


def _is_each(items: Words, lane: int, place: int) -> bool:
    after, before = items.cut(lane + 1, lane + 6), items.cut(place - 5, place)
    ends = ("number", "shoulder", "object", "divided")
    stop = next((at for at, each in enumerate(after) if each.is_a(*ends) or each.low == ";"), len(after))
    return after.cut(0, stop).has("each") or (before.has("each") and not before.has("lane", "number"))


def _way_of_sentence(items: Words, place: int) -> str:
    """The direction of the roadway whose lanes are counted: "the northbound roadway consists of three lanes"."""
    for at in range(place - 1, -1, -1):
        item: Item = items[at]
        ahead = items.cut(at + 1, at + 4)
        of_road = ahead.has("road", "lane", "divided") or ahead.says(
            {"side", "approach", "direction", "leg", "traffic"}
        )
        if item.is_a("bound", "axis") and of_road:
            return str(item.get("axis") or item.get("bound"))
        if item.low == ";":
            break
    return ""


def _implied(text: Text) -> Iterator[Claim]:
    """Two lanes, where there is one to come towards and no word of more; one where the road is one-way."""
    for sentence in text.sentences:
        for item in sentence.items:
            if item.is_a("one_way", "undivided", "two_way", "centerline", "wrong") and len(item.low) > 4:
                lanes = 1 if item.is_a("one_way") else 2
                yield claim("num_lanes", lanes, 0.5, f"no lanes are counted, but the text speaks of {item.low}", item)
                return
