"""The posted speed limits, and for which road or vehicle each is posted."""

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import KM_PER_MILE, MAX_SPEED_LIMIT, Position
from roadmend.safe.reading.facts import AXES, Text, claim, direction, of_vehicle
from roadmend.safe.reading.heads import YEARS
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.tokens import Item, Sentence, Words
from roadmend.safe.reading.wording import Wording, patterns, wording

_MOST_MPH = 85  # no road of miles is posted for more
_USUAL_MPH = 75  # where nothing tells that the country counts miles
_OF_MILES = re.compile(
    r"\b(?:mph|miles?|interstate|highway|freeway|turnpike|parkway|I-\d+|US|feet|ft)\b", re.IGNORECASE
)
_TWICE = re.compile(r"(?<=^# kmh) \( \d+ mph \)")  # "80 km/h (50 mph)" says it in two units
_LEAST_TOLD = 10
# Signs of a country of kilometres: its units, its money, its words for streets, letters that English has not.
_METRIC = re.compile(
    r"\b(?:km|kilomet\w+|metres?|euros?|zloty|kroner|crowns|koruna|francs|tempo)\b|(?:stra(?:ss|\u00df)e|gasse|platz|weg|laan"
    r"|straat|gatan|vej|utca|ulice|ulica)\b|\b(?:rue|calle|avenida|rua|corso|viale|ulica|boulevard de|national road)\b"
    r"|(?-i:[\u00c0-\u00ff\u0100-\u012f\u0132-\u017e]).*\s.*(?-i:[\u00c0-\u00ff\u0100-\u012f\u0132-\u017e])|\u20ac"
    r"|(?-i:[\u00c4-\u00c6\u00d6\u00d8\u00dc\u00df\u00e4-\u00e6\u00f6\u00f8\u00fc\u0100-\u012f\u0132-\u017e])"  # no French
    r"|\b(?:european form|articulated|saloon car|gendarm\w+|carabinieri|polizei)\b",
    re.IGNORECASE,
)
_REACH = 9  # words between "limit" and its number
_FAR_REACH = 19  # where the number has a unit
_LEAST = 5
_ROAD_REACH = 5  # words from "on" to the name of a road
_LEADS_ROAD = ("determiner", "road", "bound", "compass", "descriptor")
_ON_ROAD = frozenset({"", "travel", "approach", "stop", "emerge", "slow", "continue"})


@dataclass(frozen=True, slots=True)
class PostedLimit:
    """A posted limit.

    Attributes:
        mph: its value [mph], rounded to whole ones.
        confidence: that it is a limit.
        span: in the summary.
        ways: directions of travel that it is posted for; empty for all.
        vehicles: for which it is posted; empty for all.
        names: of the road, in lower case; empty for all.
        lanes: of the road that it is posted on, where it is called by them.
        kind: what kind of road it is posted on ("county road"), as far as a text tells its roads apart by that.
    """

    mph: int
    confidence: float
    span: Span
    ways: frozenset[Position] = frozenset()
    vehicles: frozenset[int] = frozenset()
    names: frozenset[str] = frozenset()
    lanes: int | None = None
    kind: str = ""


def read_limits(text: Text) -> tuple[PostedLimit, ...]:
    """The limits of a text."""
    units = {item.get("mph") for sentence in text.sentences for item in sentence.items}
    usual = "kmh" if "mph" not in units and ("kmh" in units or _METRIC.search(text.summary)) else "mph"
    found = [each for sentence in text.sentences for each in _of_sentence(sentence, text, usual)]
    if len({each.mph for each in found}) == 1 and not any(each.ways or each.names or each.vehicles for each in found):
        found = [replace(each, lanes=None) for each in found]  # "four lanes, 40 zone" is the only road told of
    axes = {name for name, axis in AXES.items() for each in found if each.ways & axis}
    if len(axes) == 1:  # the cross street of a road that runs north and south runs east and west
        other = next(axis for name, axis in AXES.items() if name not in axes)
        found = [replace(each, ways=other) if each.kind in word_set("minor_roads") else each for each in found]
    return tuple(dict.fromkeys(found))


def possible_limits(text: Text) -> frozenset[int]:
    """Every number of a text that may be a limit [mph], however it is put: none of a road, nor a speed that was driven."""
    found = set[int]()
    for sentence in text.sentences:
        told = wording(sentence)
        for place, item in enumerate(sentence.items):
            number = item.get("number")
            if not isinstance(number, int | float) or not _LEAST <= number <= MAX_SPEED_LIMIT * KM_PER_MILE:
                continue
            driven = sentence.items.at(place + 1).is_a("mph") and _is_no_limit(told, place)
            of_road = _is_road_number(sentence.items, place) and sentence.items.at(place - 1).low != "a"  # "it's a 45"
            if not driven and not of_road:
                found |= {round(number), round(number / KM_PER_MILE)}
    return frozenset(found)


def _of_sentence(sentence: Sentence, text: Text, usual: str) -> Iterator[PostedLimit]:
    items, end, told = sentence.items, 0, wording(sentence)
    for place in range(len(items)):
        if place >= end and (_is_worded(told, place) or _is_limit(items, place)):
            most = _MOST_MPH if _OF_MILES.search(text.summary) else _USUAL_MPH
            unit = items.at(place + 1).get("mph") or ("kmh" if items[place].get("number") > most else None)
            value, last = _in_mph(items, place, unit or usual)
            end = last + 1
            if not _is_no_limit(told, place) and _LEAST <= value <= MAX_SPEED_LIMIT:
                limit = PostedLimit(value, 0.93 if unit else 0.85, items.span(place, last))
                yield _posted(limit, items, place, last, sentence, text)


def _is_worded(told: Wording, place: int) -> bool:
    """Whether the words before or after a number make it a limit: "they let you go 55", "45 on the sign"."""
    number = told.items[place].get("number")
    if not isinstance(number, int) or number < _LEAST_TOLD or (number % 5 and not told.items.at(place + 1).is_a("mph")):
        return False
    if told.items.cut(place - 4, place).has("advisory"):
        return False
    at = told.places[place]
    before, after = told.text[:at], _TWICE.sub("", f"# {told.text[at:].partition(' ')[2]}".strip(), count=1)
    if any(pattern.search(after) for pattern in patterns("limit_never_after")):
        return False
    led = any(
        match.end() <= at
        for pattern in patterns("limit_before")
        for match in pattern.finditer(f"{before}{after}" if "#" in pattern.pattern else before)
        if match.end() == at
    )
    there = any(pattern.search(after) for pattern in patterns("limit_place"))
    there &= not any(pattern.search(before) for pattern in patterns("limit_never"))
    return led or there or any(pattern.search(after) for pattern in patterns("limit_after"))


def _is_no_limit(told: Wording, place: int) -> bool:
    """Whether a number is a speed that was driven, or none."""
    led, has_unit = told.items.at(place - 1), told.items.at(place + 1).is_a("mph")
    if (has_unit and led.is_a("lane", "road")) or (led.is_a("lane") and told.items.at(place - 2).is_a("number")):
        return False  # "SR 44, two lanes 55 mph", "a two-lane forty-five"
    at = told.places[place]
    before, after = told.text[:at], f"#{told.text[at:].partition(' ')[2]}"
    after = after.replace("#", "# ", 1) if len(after) > 1 else after
    if any(pattern.search(after) for pattern in patterns("limit_after")):
        return any(pattern.search(before) for pattern in patterns("limit_never")[2:3])
    never = any(pattern.search(before) for pattern in patterns("limit_never"))
    return never or any(pattern.search(after) for pattern in patterns("limit_never_after"))


def _is_limit(items: Words, place: int) -> bool:
    """Whether a number is a limit, and no speed driven, no count of lanes, no time."""
    number, unit, after = items[place].get("number"), items.at(place + 1).get("mph"), items.at(place + 1)
    if not isinstance(number, int | float) or number < _LEAST:
        return False
    says = any(item.verb is not None and item.verb.kind == "say" for item in items)
    words = [at for at, each in enumerate(items) if each.is_a("limit") or (says and each.low in {"sign", "signs"})]
    word = min(words, key=lambda at: abs(at - place), default=None)
    distance = abs(word - place) if word is not None else 99
    listed = len(items) <= 3 or (items.has("time", "weather") and all(item.verb is None for item in items))
    bare = items.has("lane", "road") and not items.has("thing", "body", "person", "pronoun", "insured")
    bare &= all(item.is_a("number") or not item.is_a("name") for item in items)
    listed |= bare and place == 0
    listed |= bare and place > 0 and items.at(place - 1).low in {",", ":", ";", "(", "-"}
    zone = (
        unit and (items.at(place + 2).is_a("road") or items.at(place + 2).low in {"zone", "limit"})
    ) or after.low in {"zone", "limit"}
    if (unit and listed) or zone:
        return True
    is_it = items.at(place - 1).low in {"'s", "is", "was"} and items.at(place - 2).low in {"it", "limit"}
    if is_it and number % 5 == 0 and after.low in word_set("road_follows") and items.at(place - 2).low == "it":
        return True  # "it's 40 there"
    of_clock = items.at(place - 1).low == ":" and items.at(place - 2).is_a("number")
    if of_clock or after.low in word_set("clock_marks"):
        return False
    before = items.cut(place - 8, place)
    driven = any(each.verb is not None and each.verb.kind != "own" for each in before)
    of_road = before.has("lane", "road", "divided", "each", "two_way", "middle_lane") and not driven
    is_fact = (
        of_road
        and items.at(place - 1).low not in word_set("driven_at")
        and (unit is not None or (number % 5 == 0 and _is_listed(items, place)))
    )
    if not is_fact and distance > (_FAR_REACH if unit else _REACH):
        return False
    if (
        not is_fact
        and not unit
        and (number % 5 or after.is_a("lane", "thing", "body", "time") or _parted(items, place, word))
    ):
        return False
    near = items.cut(place - 4, place)
    said = near.cut(1).first("limit")
    if near.has("advisory", "speed") and (said is None or "sign" in said.low):
        return items.cut(place + 1, place + 8).has("limit") and not near.has("advisory")
    return True


def _is_listed(items: Words, place: int) -> bool:
    """Whether a number stands by itself in a list of facts: "two lanes, 45", "2 lns 25"."""
    before, after = items.at(place - 1), items.at(place + 1)
    ends = after.low in {"", ",", ";", ".", ")"} or after.is_a("weather", "mph")
    is_last = before.low == "and" and items.at(place - 2).low == "," and not after.low
    return before.low == "," or is_last or (before.is_a("lane", "each") and ends)


def _parted(items: Words, place: int, word: int | None) -> bool:
    """Whether something else comes between the word "limit" and a number without a unit."""
    between = items.cut(min(word or place, place) + 1, max(word or place, place))
    said = {"say", "see"}
    others = [each for each in between if each.is_a("number", "time", "name", "body", "verb")]
    return any(each.verb is None or each.verb.kind not in said for each in others)


def _in_mph(items: Words, place: int, unit: str) -> tuple[int, int]:
    """The value in miles, and the last word of it: "72 km/h (45 mph)" says it twice, and best in miles."""
    number = items[place].get("number")
    last = place + items.at(place + 1).is_a("mph")
    for ahead in range(last + 1, last + 4):
        other, its_unit = items.at(ahead).get("number"), items.at(ahead + 1).get("mph")
        if isinstance(other, int | float) and its_unit and its_unit != unit:
            return round(other if its_unit == "mph" else number), ahead + 1
        if items.at(ahead).low not in {"(", "/", "or", ","}:
            break
    return round(number if unit == "mph" else number / KM_PER_MILE), last


def _posted(limit: PostedLimit, items: Words, place: int, last: int, sentence: Sentence, text: Text) -> PostedLimit:
    """What a limit is posted for, from the words around it up to the next limit."""
    units = [at for at, item in enumerate(items) if item.is_a("mph") and items.at(at - 1).is_a("number")]
    end = min([at - 1 for at in units if at > last], default=len(items))
    begin = max([at + 1 for at in units if at < place], default=0)
    after, before = items.cut(last + 1, min(end, last + 9)), items.cut(max(begin, place - 14), place)
    told = after.cut(0, 5) if after.cut(0, 1).says({"for", "on", "along"}) else Words()
    kinds = [*filter(None, (_kind_of_road(told, at) for at in range(len(told))))]
    kinds = kinds or [*filter(None, (_kind_of_road(items, at) for at in range(place - 1, begin - 1, -1)))]
    limit = replace(limit, kind=kinds[0] if kinds else "")
    for part in (after if after.cut(0, 2).says({"for", "on", "in", "along", "both"}) else Words(), before):
        if part.says({"both"}):
            return limit
        axes = [AXES[item.get("axis")] for item in part if item.is_a("axis")]
        ways = frozenset(way for item in part if item.is_a("bound") and (way := direction(item)) is not None)
        mine = [
            each
            for each in text.spoken.mentions[sentence.index]
            if part and part[0].span.start <= each.span.start < part[-1].span.end and each.description is not None
        ]
        belongs = [
            each for each in mine if items.at(each.first - 1).low == "for" or items.at(each.last + 1).low == "'s"
        ]
        vehicles = frozenset(vehicle for each in belongs for vehicle in each.vehicles)
        pairs = itertools.pairwise(part)
        lanes = next((one.get("number") for one, other in pairs if one.is_a("number") and other.is_a("lane")), None)
        names = frozenset(_name(item) for at, item in enumerate(part) if _is_road_name(part, at, sentence.span.start))
        if axes or ways or vehicles or lanes or names:
            found = frozenset().union(*axes) if axes else ways
            return replace(limit, ways=found, vehicles=vehicles, names=names, lanes=lanes)
    return limit


def _is_road_name(part: Words, at: int, start: int) -> bool:
    item, after = part[at], part.at(at + 1)
    if _is_road_number(part, at):
        return True
    proper = not item.kinds and (
        after.is_a("road", "auxiliary") or (not item.text.isupper() and item.span.start > start)
    )
    return item.is_name and (proper or item.is_a("ordinal"))


def _kind_of_road(words: Words, at: int) -> str:
    """What kind of road a word speaks of, "county road", "avenue", "valley road"; empty for any road, or for none."""
    item, before = words.at(at), words.at(at - 1)
    if item.is_a("ramp"):
        return "ramp"
    if not item.is_a("road"):
        return ""
    if item.low not in word_set("any_road"):
        return item.low
    return f"{before.low} road" if before.low.isalpha() and not before.kinds and not before.is_name else ""


def _is_road_number(words: Words, at: int) -> bool:
    """Whether a number is a road's: "Route 12", "US-20", "the A257"."""
    item, before = words[at], words.at(at - 1)
    lead = before.is_a("road") or (before.low in word_set("road_numbers") and item.get("number") not in YEARS)
    return item.is_a("number") and lead and not words.at(at + 1).is_a("mph", "lane")


def _name(item: Item) -> str:
    """A road's name; "4th" and "Fourth" are one."""
    return str(item.get("ordinal") or item.low)


def claim_limits(text: Text, limits: Sequence[PostedLimit]) -> Iterator[Claim]:
    """The claims about the vehicles' limits that need no direction: those for one vehicle, or for all."""
    roads = _roads_of_vehicles(text)
    several = len({each.mph for each in limits}) > 1
    told = frozenset[str]().union(*roads.values())
    for limit, vehicle in itertools.product(limits, range(text.count)):
        mine = roads.get(vehicle, set())
        posted = limit.names or (frozenset() if limit.ways else told & {limit.kind})
        elsewhere = any(posted & names for each, names in roads.items() if each != vehicle)
        sure = limit.confidence - 0.2 * several
        if limit.vehicles:
            sure = limit.confidence if vehicle in limit.vehicles else 0.35
        elif posted & mine:
            sure = limit.confidence
        elif posted and (elsewhere or (mine and several)):
            sure = 0.62 if not mine else 0.3 if several or "ramp" in posted else 0.55
        elif (limit.ways or limit.lanes) and not posted:
            continue
        reason = "the limit posted there" if sure > 0.5 else "a limit posted elsewhere"
        yield claim(of_vehicle(vehicle, "speed_limit_mph"), limit.mph, sure, reason, limit.span)


def _roads_of_vehicles(text: Text) -> dict[int, set[str]]:
    """By vehicle: the names of the roads that it is said to travel on."""
    found: dict[int, set[str]] = {}
    for clause in text.clauses:
        words = clause.words
        for place, item in enumerate(words if clause.kind in _ON_ROAD else ()):
            if item.low not in word_set("by_road"):
                continue
            for at in range(place + 1, min(place + _ROAD_REACH, len(words))):
                after, number, kind = words[at], _is_road_number(words, at), _kind_of_road(words, at)
                if kind:
                    for vehicle in clause.subject.vehicles:
                        found.setdefault(vehicle, set()).add(kind)
                if number or ((after.is_name or after.is_a("ordinal")) and after.low not in word_set("weekdays")):
                    for vehicle in clause.subject.vehicles:
                        found.setdefault(vehicle, set()).add(_name(after))
                leads = after.is_name or after.is_a("ordinal", *_LEADS_ROAD) or words.at(at + 1).is_a("road")
                if number or not leads:
                    break
    return found
