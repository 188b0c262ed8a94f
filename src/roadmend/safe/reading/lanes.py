"""How many lanes the road has, both directions together; at a junction, the larger road."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import MAX_LANES
from roadmend.safe.reading.facts import Text, claim
from roadmend.safe.reading.tokens import Item, Sentence

_REACH = 6  # words between a number and its "lanes"
_LIST = 12  # characters between two counts of one list


@dataclass(frozen=True, slots=True)
class LaneCount:
    """Lanes that a text counts.

    Attributes:
        number: of them.
        way: "N", "S", "E", "W", or "NS", "EW" for both directions; empty where it is not said.
        kind: "road" for those of the whole road ("a two-lane road"), "turn" and "center" for turning, "travel", "other".
        is_each: whether each direction has so many.
        is_divided: whether the road is said to be divided.
        span: in the summary.
        sentence: its number.
    """

    number: int
    way: str
    kind: str
    is_each: bool
    is_divided: bool
    span: Span
    sentence: int


def read_lanes(text: Text) -> Iterator[Claim]:
    """The claims of a text about the number of its lanes; the largest road of a place counts."""
    counts = _shared([count for sentence in text.sentences for count in _of_sentence(sentence)])
    middle = {sentence.index for sentence in text.sentences if any(item.is_a("middle_lane") for item in sentence.items)}
    counts += [
        LaneCount(1, "", "center", is_each=False, is_divided=False, span=Span(0, 0), sentence=index)
        for index in middle
        if not any(each.kind == "center" and each.sentence == index for each in counts)
    ]
    totals: list[tuple[int, float, str, Span]] = []
    for count in counts:
        if count.kind == "road":
            totals.append(
                (count.number + _turning(counts, count), 0.93, "the text counts the lanes of the road", count.span)
            )
        elif count.is_each and count.kind in {"travel", ""}:
            center = _center(counts, count)
            center += 2 * sum(
                each.number
                for each in counts
                if each.is_each and each.sentence == count.sentence and each.kind == "turn"
            )
            totals.append((2 * count.number + center, 0.92, "the text counts the lanes of each direction", count.span))
        elif count.way in {"NS", "EW"} and count.kind == "travel":
            totals.append((count.number, 0.75, "the text counts the lanes of both directions", count.span))
    totals += _by_way(counts)
    if not totals:
        totals += _bare(counts, text)
    if totals:
        largest = max(number for number, *_ in totals)
        for number, confidence, reason, span in totals:
            if 1 <= number <= MAX_LANES:
                yield claim(
                    "num_lanes", number, confidence if number == largest else min(confidence, 0.3), reason, span
                )
    else:
        yield from _implied(text)


def _shared(counts: Sequence[LaneCount]) -> list[LaneCount]:
    """Let "each direction" hold for all that is listed before it: "two through lanes and a turn lane for each direction"."""
    found = list(counts)
    for place in range(len(found) - 1, 0, -1):
        one, other = found[place - 1], found[place]
        near = one.sentence == other.sentence and other.span.start - one.span.end < _LIST
        if (
            other.is_each
            and near
            and one.kind != other.kind
            and len(one.way) != 1
            and not one.is_each
            and one.kind in {"travel", "turn"}
        ):
            found[place - 1] = replace(one, is_each=True)
    return found


def _center(counts: Sequence[LaneCount], count: LaneCount) -> int:
    near = [
        each
        for each in counts
        if each.kind in {"center", "turn"}
        and abs(each.sentence - count.sentence) <= 1
        and each.way == ""
        and not each.is_each
    ]
    return near[0].number if near and (near[0].kind == "center" or near[0].sentence == count.sentence) else 0


def _turning(counts: Sequence[LaneCount], count: LaneCount) -> int:
    """The turning lane between the directions: a road with one has an odd number of lanes."""
    middle = any(each.kind == "center" and each.sentence == count.sentence for each in counts)
    return 1 if middle and count.number % 2 == 0 else 0


def _by_way(counts: Sequence[LaneCount]) -> list[tuple[int, float, str, Span]]:
    """Roads whose lanes are counted for each direction apart: "three northbound and two southbound lanes"."""
    found = []
    for axis in ("NS", "EW"):
        ways = {way: _of_way([each for each in counts if each.way == way and not each.is_each]) for way in axis}
        known = {way: sum_ for way, sum_ in ways.items() if sum_ is not None}
        if not known:
            continue
        spans = [each.span for each in counts if each.way in axis and each.way]
        if len(known) == 2:
            first = next(each.sentence for each in counts if each.way in axis and each.way)
            shared = [
                each
                for each in counts
                if each.way == "" and each.kind in {"center", "turn"} and 0 <= each.sentence - first <= 1
            ]
            extra = sum(each.number for each in shared if each.kind == "center" or each.number == 1)
            found.append((sum(known.values()) + extra, 0.9, "the text counts the lanes of both directions", spans[0]))
        elif sum(known.values()) > 0:
            own = next(iter(known.values()))
            found.append((2 if own == 1 else own, 0.6, "the text counts the lanes of one direction alone", spans[0]))
    return found


def _of_way(counts: Sequence[LaneCount]) -> int | None:
    """The lanes of one direction: the general count with what is added to it, or the kinds that make it up."""
    plain = [each for each in counts if each.kind == "travel"]
    turning = [each for each in counts if each.kind in {"turn", "center"}]
    if not plain:
        return sum(each.number for each in turning) if turning else None
    general = max(plain, key=lambda each: each.number)
    rest = sum(each.number for each in plain if each is not general and each.sentence == general.sentence)
    parts = rest + sum(each.number for each in turning)
    same = [each for each in turning if each.sentence == general.sentence]
    if general.number > 1 and parts == general.number:
        return general.number  # the kinds spell the general count out
    return general.number + sum(each.number for each in same)


def _bare(counts: Sequence[LaneCount], text: Text) -> list[tuple[int, float, str, Span]]:
    plain = [each for each in counts if each.kind == "travel" and each.way == ""]
    if not plain:
        return []
    most = max(plain, key=lambda each: each.number)
    one_way = any(item.is_a("one_way") for sentence in text.sentences for item in sentence.items)
    turning = sum(
        each.number
        for each in counts
        if each.kind in {"turn", "center"} and each.way == "" and each.sentence == most.sentence and each.span.end
    )
    is_single = most.number == 1 and not one_way
    total = 2 if is_single else most.number + (turning if most.number > 1 else 0)
    return [
        (
            total,
            0.55 if not most.is_divided else 0.4,
            "the text counts lanes and does not say of which direction",
            most.span,
        )
    ]


def _of_sentence(sentence: Sentence) -> Iterator[LaneCount]:
    items = sentence.items
    is_divided = any(item.is_a("divided") or item.kinds.get("road") == "divided" for item in items)
    place = 0
    while place < len(items):
        number = items[place].kinds.get("number")
        if items[place].low in {"a", "an"} and place + 2 < len(items):
            is_each = items[place + 1].is_a("lane") and items[place + 2].is_a("each")
            is_center = items[place + 1].kinds.get("lanekind") == "center" and items[place + 2].is_a("lane")
            number = 1 if is_each or is_center else number
        if not isinstance(number, int) or not 1 <= number <= 12 or items[place].is_a("time"):
            place += 1
            continue
        lane = _lane_after(items, place)
        if lane is None:
            place += 1
            continue
        found = _count(items, place, lane, sentence, is_divided=is_divided)
        if found is not None:
            yield found
        place += 1


def _lane_after(items: Sequence[Item], place: int) -> int | None:
    for at in range(place + 1, min(place + 1 + _REACH, len(items))):
        item = items[at]
        if item.is_a("lane"):
            return at
        if item.low in {"and", ","} and at + 1 < len(items) and items[at + 1].is_a("number"):
            continue
        if item.is_a("number", "bound") and any(each.is_a("bound") for each in items[place + 1 : at]):
            continue  # "two southbound and four northbound lanes"
        if (
            item.is_a("lanekind", "bound", "compass", "hand", "descriptor", "straight", "two_way")
            or not item.kinds
            or item.low in {"and", "only"}
        ):
            if item.low in ".;:()%" or item.is_a("mph"):
                return None
            continue
        return None
    return None


def _count(items: Sequence[Item], place: int, lane: int, sentence: Sentence, *, is_divided: bool) -> LaneCount | None:
    number = int(items[place].kinds.get("number", 1))
    between = items[place + 1 : lane]
    stop = next(
        (
            at
            for at, each in enumerate(between)
            if each.low == "and" and any(one.is_a("number") for one in between[at:])
        ),
        len(between),
    )
    own = between[:stop]
    kinds = {each.kinds.get("lanekind") for each in own if each.is_a("lanekind")} - {None}
    after = items[lane + 1 : lane + 8]
    ways = [each.kinds["bound"] for each in own if each.is_a("bound")]
    compass = [each.kinds["compass"] for each in own if each.is_a("compass") and len(each.kinds["compass"]) == 1]
    way = (ways or compass or [""])[0]
    singular = items[lane].low in {"lane", "ln", "lande"}
    is_each = _is_each(items, lane, place)
    kind = next((each for each in ("other", "center", "turn") if each in kinds), "travel")
    if not way and after:
        follows = next(
            (
                at
                for at, each in enumerate(after[:4])
                if each.is_a("bound", "axis")
                or (each.is_a("compass") and at and after[at - 1].low in {"for", "heading", "going", "traveling"})
            ),
            None,
        )
        if follows is not None and not any(each.low in ",;" or each.is_a("number") for each in after[:follows]):
            both = [each.kinds["bound"] for each in after[follows : follows + 4] if each.is_a("bound")]
            way = (
                after[follows].kinds.get("axis")
                or after[follows].kinds.get("bound")
                or after[follows].kinds.get("compass")
            )
            if len(both) > 1 and set(both) in ({"N", "S"}, {"E", "W"}):
                is_each = True
    if singular and number > 1 and not is_each and kind == "travel" and not way:
        return LaneCount(
            number,
            "",
            "road",
            is_each=False,
            is_divided=is_divided,
            span=_span(items, place, lane),
            sentence=sentence.index,
        )
    led = {each.low for each in items[max(0, place - 3) : place]}
    if (
        not way
        and not is_each
        and kind == "travel"
        and number > 1
        and led & {"has", "have", "had", "with"}
        and any(each.is_a("road") or each.text[:1].isupper() for each in items[max(0, place - 6) : place])
        and not _way_of_sentence(items, place)
    ):
        return LaneCount(
            number,
            "",
            "road",
            is_each=False,
            is_divided=is_divided,
            span=_span(items, place, lane),
            sentence=sentence.index,
        )
    if not way and kind != "other":
        way = _way_of_sentence(items, place)
    return LaneCount(
        number,
        way,
        kind,
        is_each=is_each,
        is_divided=is_divided,
        span=_span(items, place, lane),
        sentence=sentence.index,
    )


def _is_each(items: Sequence[Item], lane: int, place: int) -> bool:
    after = items[lane + 1 : lane + 6]
    stop = next((at for at, each in enumerate(after) if each.is_a("number") or each.low == ";"), len(after))
    if any(each.is_a("each") for each in after[:stop]):
        return True
    before = items[max(0, place - 5) : place]
    return any(each.is_a("each") for each in before) and not any(each.is_a("lane", "number") for each in before)


def _way_of_sentence(items: Sequence[Item], place: int) -> str:
    """The direction of the roadway whose lanes are counted: "the northbound roadway consists of three lanes"."""
    for at in range(place - 1, -1, -1):
        item = items[at]
        if item.is_a("bound", "axis") and at + 1 < len(items):
            ahead = items[at + 1 : at + 4]
            if any(
                each.is_a("road", "lane", "divided") or each.low in {"side", "approach", "direction", "leg", "traffic"}
                for each in ahead
            ):
                return str(item.kinds.get("axis") or item.kinds.get("bound"))
        if item.low == ";":
            break
    return ""


def _span(items: Sequence[Item], first: int, last: int) -> Span:
    return Span(items[first].span.start, items[last].span.end)


def _implied(text: Text) -> Iterator[Claim]:
    """Two lanes, where there is one to come towards and no word of more."""
    for sentence in text.sentences:
        for item in sentence.items:
            if item.is_a("one_way"):
                yield claim("num_lanes", 1, 0.5, "no lanes are counted, and the road is one-way", item.span)
                return
            if item.is_a("undivided", "two_way", "centerline", "wrong") and len(item.low) > 4:
                yield claim("num_lanes", 2, 0.5, f"no lanes are counted, but the text speaks of {item.low}", item.span)
                return
