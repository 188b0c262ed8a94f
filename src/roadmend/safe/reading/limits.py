"""The posted speed limits, and for which road or vehicle each is posted."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import MAX_SPEED_LIMIT, Position
from roadmend.safe.reading.facts import AXES, Text, claim, direction, of_vehicle
from roadmend.safe.reading.tokens import Item, Sentence

_KMH = 1.609344
_REACH = 9  # words between "limit" and its number
_LEAST = 5


@dataclass(frozen=True, slots=True)
class PostedLimit:
    """A posted limit.

    Attributes:
        mph: its value [mph], rounded to whole ones.
        ways: directions of travel that it is posted for; empty for all.
        vehicles: for which it is posted; empty for all.
        names: of the road, in lower case; empty for all.
        lanes: of the road that it is posted on, where it is called by them.
        confidence: that it is a limit.
        span: in the summary.
    """

    mph: int
    ways: frozenset[Position]
    vehicles: frozenset[int]
    names: frozenset[str]
    lanes: int | None
    confidence: float
    span: Span


def read_limits(text: Text) -> tuple[PostedLimit, ...]:
    """The limits of a text."""
    is_metric = any(
        item.kinds.get("mph") == "kmh" for sentence in text.sentences for item in sentence.items
    ) and not any(item.kinds.get("mph") == "mph" for sentence in text.sentences for item in sentence.items)
    found = [limit for sentence in text.sentences for limit in _of_sentence(sentence, text, is_metric=is_metric)]
    return tuple(dict.fromkeys(found))


def _of_sentence(sentence: Sentence, text: Text, *, is_metric: bool) -> Iterator[PostedLimit]:
    items = sentence.items
    says = any(item.verb is not None and item.verb.kind == "say" for item in items)
    words = [
        place for place, item in enumerate(items) if item.is_a("limit") or (says and item.low in {"sign", "signs"})
    ]
    used: set[int] = set()
    for place, item in enumerate(items):
        number = item.kinds.get("number")
        if not isinstance(number, int | float) or place in used or number < _LEAST:
            continue
        unit = items[place + 1].kinds.get("mph") if place + 1 < len(items) else None
        nearest = min((abs(place - word) for word in words), default=99)
        listed = any(item.is_a("time", "weather") for item in items) and all(item.verb is None for item in items)
        alone = unit is not None and (len(items) <= 3 or listed)
        zone = (
            alone
            or (place + 1 < len(items) and items[place + 1].low in {"zone", "limit"})
            or (place + 2 < len(items) and unit and items[place + 2].low in {"zone", "limit", "road"})
        )
        is_fact = _is_road_fact(items, place) and (
            unit is not None or (number % 5 == 0 and place > 0 and items[place - 1].low == ",")
        )
        if nearest > _REACH + (10 if unit else 0) and not zone and not is_fact:
            continue
        if (
            unit is None
            and not zone
            and not is_fact
            and (
                nearest > _REACH
                or number % 5
                or (place + 1 < len(items) and items[place + 1].is_a("lane", "thing", "body", "time"))
                or not _is_bare_limit(items, place, words)
            )
        ):
            continue
        if (
            any(each.is_a("advisory", "speed") for each in items[max(0, place - 4) : place])
            and not any(each.is_a("limit") for each in items[max(0, place - 3) : place])
            and not zone
        ):
            follows = any(each.is_a("limit") for each in items[place + 1 : place + 8])
            if not follows or any(each.is_a("advisory") for each in items[max(0, place - 4) : place]):
                continue
        value, last = _in_mph(items, place, unit or ("kmh" if is_metric else "mph"))
        used.update(range(place, last + 1))
        if not _LEAST <= value <= MAX_SPEED_LIMIT:
            continue
        ways, vehicles, names, lanes = _place(items, place, last, sentence, text)
        yield PostedLimit(
            value, ways, vehicles, names, lanes, 0.93 if unit else 0.85, Span(item.span.start, items[last].span.end)
        )


def _is_bare_limit(items: Sequence[Item], place: int, words: Sequence[int]) -> bool:
    """Whether nothing else comes between the word "limit" and a number without a unit."""
    word = min(words, key=lambda each: abs(each - place))
    between = items[min(word, place) + 1 : max(word, place)]
    return not any(
        each.is_a("number", "time", "name", "body", "verb")
        and not (each.verb is not None and each.verb.kind in {"say", "see"})
        for each in between
    )


def _is_road_fact(items: Sequence[Item], place: int) -> bool:
    """Whether a speed stands among facts about the road: "2 lane rd, 45 mph"."""
    near = items[max(0, place - 5) : place]
    return any(each.is_a("lane", "road", "divided", "each", "two_way", "middle_lane") for each in near) and not any(
        each.verb is not None and each.verb.kind != "own" for each in near
    )


def _in_mph(items: Sequence[Item], place: int, unit: str) -> tuple[int, int]:
    """The value in miles, and the last word of it: "72 km/h (45 mph)" says it twice, and best in miles."""
    number = items[place].kinds["number"]
    last = place + 1 if place + 1 < len(items) and items[place + 1].is_a("mph") else place
    for ahead in range(last + 1, min(last + 4, len(items) - 1)):
        other = items[ahead].kinds.get("number")
        if isinstance(other, int | float) and items[ahead + 1].is_a("mph") and items[ahead + 1].kinds["mph"] != unit:
            if items[ahead + 1].kinds["mph"] == "mph":
                return round(other), ahead + 1
            return round(number), ahead + 1
        if items[ahead].low not in {"(", "/", "or", ","}:
            break
    return round(number if unit == "mph" else number / _KMH), last


def _place(
    items: Sequence[Item], place: int, last: int, sentence: Sentence, text: Text
) -> tuple[frozenset[Position], frozenset[int], frozenset[str], int | None]:
    """What a limit is posted for, from the words around it up to the next limit."""
    numbers = [
        at
        for at, item in enumerate(items)
        if item.is_a("mph") and at > 0 and isinstance(items[at - 1].kinds.get("number"), int | float)
    ]
    end = next((at - 1 for at in numbers if at > last), len(items))
    begin = max((at + 1 for at in numbers if at < place), default=0)
    after = items[last + 1 : min(end, last + 9)]
    before = items[max(begin, place - 14) : place]
    for part in (after if any(each.low in {"for", "on", "in", "along", "both"} for each in after[:2]) else [], before):
        if not part:
            continue
        if any(each.low == "both" for each in part):
            return frozenset(), frozenset(), frozenset(), None
        ways = {way for each in part if (way := direction(each)) is not None and each.is_a("bound")}
        axes = [AXES[each.kinds["axis"]] for each in part if each.is_a("axis")]
        found = frozenset().union(*axes) if axes else frozenset(ways)
        vehicles = frozenset(
            vehicle
            for mention in text.spoken.mentions[sentence.index]
            if part[0].span.start <= mention.span.start < part[-1].span.end
            and mention.description is not None
            and _belongs(items, mention.first, mention.last)
            for vehicle in mention.vehicles
        )
        lanes = next(
            (
                each.kinds["number"]
                for each, following in itertools.pairwise(part)
                if each.is_a("number") and following.is_a("lane")
            ),
            None,
        )
        names = frozenset(
            _name(each)
            for each, following in zip(part, [*part[1:], None], strict=False)
            if (each.text[:1].isupper() and each.is_a("ordinal"))
            or (
                each.text[:1].isupper()
                and not each.kinds
                and not each.text.isupper()
                and each.span.start > sentence.span.start
            )
            or (
                each.text[:1].isupper()
                and not each.kinds
                and following is not None
                and (following.is_a("road") or following.is_a("auxiliary"))
            )
        )
        if found or vehicles or lanes or names:
            return found, vehicles, names, lanes
    return frozenset(), frozenset(), frozenset(), None


def _name(item: Item) -> str:
    """A road's name; "4th" and "Fourth" are one."""
    return str(item.kinds.get("ordinal", item.low))


def _belongs(items: Sequence[Item], first: int, last: int) -> bool:
    """Whether a limit is said to be this vehicle's: "for V2", "V2's limit"."""
    return (first > 0 and items[first - 1].low == "for") or (last + 1 < len(items) and items[last + 1].low == "'s")


def claim_limits(text: Text, limits: Sequence[PostedLimit]) -> Iterator[Claim]:
    """The claims about the vehicles' limits that need no direction: those for one vehicle, or for all."""
    roads = _roads_of_vehicles(text)
    for limit in limits:
        for vehicle in range(text.count):
            mine = roads.get(vehicle, frozenset())
            others = (
                frozenset().union(*(names for each, names in roads.items() if each != vehicle))
                if roads
                else frozenset()
            )
            if limit.vehicles:
                confidence = limit.confidence if vehicle in limit.vehicles else 0.35
            elif limit.names & mine:
                confidence = limit.confidence
            elif limit.names and limit.names & others:
                confidence = 0.3 if mine else 0.62
            elif limit.names and mine and len({each.mph for each in limits}) > 1:
                confidence = 0.3
            elif (limit.ways or limit.lanes) and not limit.names:
                continue
            else:
                confidence = limit.confidence - (0.2 if len({each.mph for each in limits}) > 1 else 0.0)
            yield claim(
                of_vehicle(vehicle, "speed_limit_mph"),
                limit.mph,
                confidence,
                "the limit posted there" if confidence > 0.5 else "a limit posted elsewhere",
                limit.span,
            )


def _roads_of_vehicles(text: Text) -> dict[int, frozenset[str]]:
    """By vehicle: the names of the roads that it is said to travel on."""
    found: dict[int, set[str]] = {}
    for clause in text.clauses:
        if clause.subject is None or clause.kind not in {
            "",
            "travel",
            "approach",
            "stop",
            "emerge",
            "slow",
            "continue",
        }:
            continue
        words = [*clause.head, *clause.tail]
        for place, item in enumerate(words):
            if (
                item.low in {"on", "along", "down", "off"}
                and place + 1 < len(words)
                and (words[place + 1].text[:1].isupper() or words[place + 1].is_a("ordinal"))
            ):
                for vehicle in clause.subject.vehicles:
                    found.setdefault(vehicle, set()).add(_name(words[place + 1]))
    return {vehicle: frozenset(names) for vehicle, names in found.items()}
