"""Where a text speaks of vehicles, and which vehicle each time: "V1", "a 2004 Honda Civic", "the pickup", "my car"."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from roadmend.safe.claims import Span
from roadmend.safe.reading.cast import Description, Roll, Vehicle
from roadmend.safe.reading.heads import TRAITS, is_head, read_group
from roadmend.safe.reading.lexicon import BodySense, word_set
from roadmend.safe.reading.tokens import Item, Sentence, Words

_MOST_VEHICLES = 9
_PADDED = frozenset({"01", "02", "03", "04"})
_HEADLINE = 16  # words
STRIKES = frozenset({"strike", "strike_rear", "strike_side", "strike_swipe"})
_APPOSITION = 6  # words at most between two names of one vehicle
_REACH = 6  # words between "I" and the car that I sit in
_LETTERS = {"a": 1, "b": 2, "c": 3, "d": 4}


class MentionKind(StrEnum):
    """How a vehicle is called."""

    NAMED = "named"  # by number or description
    SELF = "self"  # "I", "my car"
    OTHER = "other"  # "the other driver"
    PERSON = "person"  # "the driver", "a woman"
    IT = "it"
    ONE = "one"  # "he", "they"
    POSSESSIVE = "its"  # "its", "his"
    BOTH = "both"


@dataclass(slots=True)
class Mention:
    """One place where a text speaks of vehicles.

    Attributes:
        first: its first word in the sentence.
        last: its last.
        kind: how it is called.
        span: in the summary.
        vehicles: which, by place in the cast; empty while open.
        is_new: whether its article says that it was not spoken of before.
        traits: words that go with it and say something of it: "northbound", "parked".
        description: of a described one.
        is_person: whether it is the driver that is spoken of.
        twin: the mention beside it that is of the same vehicle.
        bodies: of several: what they all are.
    """

    first: int
    last: int
    kind: MentionKind
    span: Span = field(default=Span(0, 0))
    vehicles: tuple[int, ...] = ()
    is_new: bool = False
    traits: tuple[Item, ...] = ()
    description: Description | None = None
    is_person: bool = False
    twin: "Mention | None" = None
    bodies: tuple[tuple[BodySense, Span], ...] = ()

    @property
    def number(self) -> int | None:
        """The report's, of a numbered one."""
        return self.description.number if self.description is not None else None


@dataclass(slots=True)
class Spoken:
    """The vehicles of a text and where it speaks of them, by sentence."""

    roll: Roll = field(default_factory=Roll)
    mentions: list[list[Mention]] = field(default_factory=list)


def find_mentions(sentences: Sequence[Sentence]) -> Spoken:
    """Find all mentions of a text, and name the vehicles that are called by number or description."""
    spoken, found = Spoken(), [list(_mentions(sentence.items)) for sentence in sentences]
    roll = spoken.roll
    roll.enrol(sorted({each.number for row in found for each in row if each.number}))
    for sentence, row in zip(sentences, found, strict=True):
        _couple(sentence.items, row)
        _own(sentence.items, row)
        for mention in row:  # first, for a report may speak of "a 2004 Civic" before it gives it a number
            if mention.description is not None and mention.number is not None:
                mention.vehicles = roll.call(mention.description, is_new=False, is_headline=False)
    paragraphs = {id(each): at.paragraph for at, row in zip(sentences, found, strict=True) for each in row}
    firsts: dict[int, int] = {}
    for each in (each for row in found for each in row if each.number):
        firsts.setdefault(each.vehicles[0], each.span.start)
    headlines = [_is_headline(sentence, sentences) for sentence in sentences]
    in_body = any(
        each.description for row, is_title in zip(found, headlines, strict=True) if not is_title for each in row
    )
    for is_headline, row in sorted(zip(headlines, found, strict=True), key=lambda each: each[0]):
        for mention in row:
            if mention.twin is not None and mention.twin.vehicles:
                mention.vehicles = mention.twin.vehicles
            if mention.vehicles:
                roll.latest = mention.vehicles[0]
            elif mention.description is not None:
                early = roll.to_come(mention.description, mention.span.start, firsts)
                if early:
                    mention.vehicles = early
                elif is_headline and in_body:  # a headline tells of those of whom the text tells
                    mention.vehicles = roll.known(mention.description)
                else:
                    is_new = mention.is_new and not roll.is_told_again(mention.description, paragraphs[id(mention)])
                    mention.vehicles = roll.call(mention.description, is_new=is_new, is_headline=is_headline)
                    roll.note(mention.vehicles, paragraphs[id(mention)])
    _possess(sentences, found)
    _relate(sentences, found)
    _elliptic(sentences, found, roll)
    _take_part(sentences, found, roll)
    alike = next((each.bodies for row in found for each in row if each.bodies), ())
    for vehicle in roll.vehicles if alike else ():
        if vehicle.description.body()[0] is None:
            vehicle.description = replace(vehicle.description, bodies=alike)
    _lead(sentences, found, headlines, roll)
    _sort(found, headlines, roll)
    own = roll.own()
    for sentence, row in zip(sentences, found, strict=True):
        _seat(sentence.items, row)
        for mention in row:
            mention.vehicles = own if mention.kind is MentionKind.SELF else mention.vehicles
        spoken.mentions.append(list(row))
    return spoken


def _is_headline(sentence: Sentence, sentences: Sequence[Sentence]) -> bool:
    """Whether it stands alone over a text, as a newspaper's headline does."""
    alone = sum(each.paragraph == sentence.paragraph for each in sentences) == 1
    return alone and sentence.paragraph == 0 and len(sentence.items) < _HEADLINE and len(sentences) > 1


def _own(items: Words, row: Sequence[Mention]) -> None:
    """Take the vehicle that the writer says to sit in for the writer's: "I was in the Civic"."""
    for one, other in itertools.pairwise(row):
        between = items.cut(one.last + 1, other.first)
        sits = 0 < len(between) < _REACH and between[-1].low in word_set("sits_in")
        sits |= (
            1 < len(between) < _REACH and between[-1].get("auxiliary") == "be" and between.has("thing")
        )  # "my vehicle is"
        if sits and one.kind is MentionKind.SELF and other.description is not None and not other.number:
            other.description = replace(other.description, is_own=True)


def _elliptic(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], roll: Roll) -> None:
    """Take the vehicle that somebody sits in for the writer's, where one speaks of "me" and of no car of mine."""
    if roll.own() or not any(each.kind is MentionKind.SELF for row in found for each in row):
        return
    for sentence, row in zip(sentences, found, strict=True):
        for mention in row:
            led = sentence.items.at(mention.first - 1).low in {"in", "driving"}
            seated = any(each.last < mention.first and each.kind is not MentionKind.SELF for each in row)
            if led and not seated and mention.description and mention.vehicles and not mention.is_new:
                vehicle = roll.vehicles[mention.vehicles[0]]
                vehicle.description = replace(vehicle.description, is_own=True)
                return


def _take_part(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], roll: Roll) -> None:
    """Give the writer a vehicle where the text tells that the writer drove, and of no vehicle of the writer's."""
    if roll.own() or len(roll.vehicles) != 1 or roll.vehicles[0].description.number is not None:
        return
    drives = any(
        mention.kind is MentionKind.SELF and (_drives(sentence.items, mention) or _is_struck(sentence.items, mention))
        for sentence, row in zip(sentences, found, strict=True)
        for mention in row
    )
    if not drives:
        return
    others = (each.description for row in found for each in row if each.description and each.vehicles)
    like = next((each.bodies for each in others if "another" in each.marks or each.is_other), ())
    roll.vehicles.append(Vehicle(len(roll.vehicles), Description(bodies=like, is_own=True, words="vehicle")))


def _drives(items: Words, mention: Mention) -> bool:
    after = items.cut(mention.last + 1, mention.last + 5)
    told = any(item.verb is not None and item.verb.lemma in word_set("drives") for item in after.cut(0, 3))
    return after.at(0).get("auxiliary") is not None and (told or after.has("bound", "lane"))


def _is_struck(items: Words, mention: Mention) -> bool:
    before = items.at(mention.first - 1)
    return items[mention.first].low == "me" and before.verb is not None and before.verb.kind in STRIKES


def _lead(
    sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], headlines: Sequence[bool], roll: Roll
) -> None:
    """Let "a driver" who strikes one of two vehicles in the first sentence be the other's."""
    if len(roll.vehicles) != 2:
        return
    rows = zip(sentences, found, headlines, strict=True)
    sentence, row = next(((each, row) for each, row, is_title in rows if not is_title and row), (None, ()))
    struck = next((each for each in row if each.description is not None and len(each.vehicles) == 1), None)
    person = row[0] if row else None
    if sentence is None or struck is None or person is None or person.kind is not MentionKind.PERSON or person.vehicles:
        return
    between = sentence.items.cut(person.last + 1, struck.first)
    strikes = any(item.verb is not None and item.verb.kind in STRIKES for item in between)
    if (
        strikes
        and not between.has("conjunction")
        and sentence.items[person.last].get("person") in {"driver", "someone"}
    ):
        person.vehicles = (1 - struck.vehicles[0],)


def _sort(found: Sequence[Sequence[Mention]], headlines: Sequence[bool], roll: Roll) -> None:
    """Put the vehicles into the order in which they come up, the writer's with the first "I"."""
    own, first = roll.own(), dict[int, int]()
    if any(each.description.number is not None for each in roll.vehicles):
        return
    for is_title, row in zip(headlines, found, strict=True):
        for mention in () if is_title else row:
            for place in (
                mention.vehicles[:1]
                if mention.description is not None or (row[0] is mention and mention.kind is MentionKind.PERSON)
                else ()
            ):
                first.setdefault(place, mention.span.start)
    unnamed = own if own and own[0] not in first else ()
    titled = any(
        each.vehicles == own for is_title, row in zip(headlines, found, strict=True) for each in row if is_title
    )
    starts = [each.span.start for row in found for each in row if each.kind is MentionKind.SELF]
    if own and titled:
        first[own[0]] = -1
    elif unnamed and starts:
        first[own[0]] = starts[0]
    old = sorted(range(len(roll.vehicles)), key=lambda place: (first.get(place, math.inf), place))
    new = {place: at for at, place in enumerate(old)}
    roll.vehicles = [roll.vehicles[place] for place in old]
    for at, vehicle in enumerate(roll.vehicles):
        vehicle.place = at
    for mention in (each for row in found for each in row):
        mention.vehicles = tuple(new[place] for place in mention.vehicles)


def _relate(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> None:
    """Put a person into the vehicle that the same sentence calls hers or his: "a teacher was turning in her Corsa"."""
    for sentence, row in zip(sentences, found, strict=True):
        theirs = next((each for each in row if each.description is not None and each.description.is_theirs), None)
        for mention in row if theirs is not None else ():
            item = sentence.items[mention.last]
            someone = item.get("person") == "someone" or item.low in word_set("relatives")
            if mention.kind is MentionKind.PERSON and not mention.vehicles and someone and theirs is not None:
                mention.vehicles = theirs.vehicles if mention.last < theirs.first else ()


def _possess(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> None:
    """Give a "she" with whom a text begins the vehicle that it calls hers: "drifted into her Altima"."""
    rows = [(place, mention) for place, row in enumerate(found) for mention in row]
    described = [(place, each) for place, each in rows if each.description is not None]
    hers = next(((place, each) for place, each in described if each.description and each.description.is_theirs), None)
    for place, mention in rows if hers is not None else ():
        early = mention.span.start < described[0][1].span.start
        someone = mention.kind is MentionKind.PERSON and sentences[place].items[mention.last].get("person") == "someone"
        is_one = mention.kind is MentionKind.ONE or someone
        if hers is not None and early and place <= hers[0] and is_one and not mention.vehicles:
            mention.vehicles = hers[1].vehicles


def _seat(items: Words, row: Sequence[Mention]) -> None:
    """Put a person into the vehicle that it is said to sit in: "he's in a Dodge Ram"."""
    for one, other in itertools.pairwise(row):
        between = items.cut(one.last + 1, other.first)
        sits = 0 < len(between) <= 3 and between[-1].low in word_set("sits_in") - {"'s"}
        if sits and one.kind in {MentionKind.ONE, MentionKind.PERSON} and not one.vehicles and other.description:
            one.vehicles = other.vehicles
    for place, one in enumerate(row):  # "the woman who hit me was in a Nissan"
        if one.kind is MentionKind.PERSON and not one.vehicles and items.at(one.last + 1).is_a("relative"):
            seats = [each for each in row[place + 1 :] if each.description and each.vehicles]
            led = items.cut(seats[0].first - 2, seats[0].first) if seats else Words()
            if led.says(word_set("sits_in")) and led.at(0).get("auxiliary") == "be":
                one.vehicles = seats[0].vehicles


def _couple(items: Words, row: Sequence[Mention]) -> None:
    """Give two names of one vehicle that stand side by side one description: "Vehicle 1, a 2004 Honda Civic"."""
    for one, other in itertools.pairwise([each for each in row if each.description is not None]):
        between = items.cut(one.last + 1, other.first)
        if one.description is None or other.description is None or (one.number and other.number):
            continue
        named_again = bool(between) and all(item.is_a("thing") for item in between)
        if not named_again and (len(between) > _APPOSITION or not _is_apposition(between, other)):
            continue
        numbered = one.number or other.number
        if not numbered and (not other.is_new or one.description.contradicts(other.description)):
            continue
        one.description = other.description = one.description.merged(other.description)
        other.is_new, other.twin = one.is_new, one


def _is_apposition(between: Words, other: Mention) -> bool:
    if not between:
        return True
    is_copula = all(item.get("auxiliary") == "be" or item.low == ")" for item in between)
    has_mark = between.says(word_set("apposition_marks"))
    plain = all(item.low in word_set("apposition") or item.is_a("thing", "descriptor") for item in between)
    unknown = len(between) <= 2 and all(not item.kinds and item.low.isalpha() for item in between)  # "veh 1 unk pickup"
    return (is_copula and other.is_new) or (plain and has_mark) or unknown


def _mentions(items: Words) -> Iterator[Mention]:
    place = 0
    while place < len(items):
        mention = _numbered(items, place) or _described(items, place) or _pronoun(items, place)
        if mention is None:
            place += 1
            continue
        _take_driver(items, mention)
        after = items.at(mention.last + 1)
        ends = items.at(mention.last + 2).low in word_set("trait_ends") or items.at(mention.last + 2).is_a("negation")
        if after.is_a("bound") and ends and mention.description is not None:
            mention.traits = (*mention.traits, after)  # "struck U2 EB"
        while mention is not None:
            mention.span = items.span(mention.first, mention.last)
            yield mention
            place = mention.last + 1
            mention = _more_numbers(items, place) if mention.number is not None else None  # "vehicles 1 and 2"


def _number(items: Words, place: int) -> int | None:
    number = items.at(place).get("number")
    return number if isinstance(number, int) and 1 <= number <= _MOST_VEHICLES else None


def _numbered(items: Words, place: int) -> Mention | None:
    head = items[place]
    ordinal = items.at(place - 1).get("ordinal")
    if head.low in {"vehicle", "unit"} and ordinal and items.at(place + 1).low == ",":
        described = Description(number=ordinal, span=items.span(place - 1, place))
        return Mention(place, place, MentionKind.NAMED, description=described)
    if head.low in _PADDED or (
        head.low == "#" and _number(items, place + 1) and not items.at(place - 1).is_a("thing", "person", "lane")
    ):
        at = place + (head.low == "#")
        aside = (
            items.at(place - 1).low in {":", "/", "$"}
            or items.at(at + 1).low in {":", "/"}
            or items.at(at + 1).is_a("name")
        )
        aside |= items.at(place - 1).is_a("thing", "number", "person")
        if not aside and not items.at(at + 1).is_a("lane", "mph", "time", "number"):
            described = Description(number=_number(items, at), span=items.span(place, at))
            return Mention(place, at, MentionKind.NAMED, description=described)
    is_person = head.get("person") == "driver"
    if not (head.is_a("thing") or is_person or head.low in word_set("bare_things")):
        return None
    at = place + 1
    while items.at(at).low in word_set("number_marks"):
        at += 1
    label, following = items.at(at), items.at(at + 1)
    number = _number(items, at)
    if number is None and len(label.text) == 1 and label.text.isupper() and len(head.low) > 1:
        number = _LETTERS.get(label.low) if not following.is_a("name", "body", "descriptor") else None
    apart = len(head.low) == 1 and label.span.start - head.span.end > 1
    if number is None or following.is_a("lane", "time", "mph") or head.get("thing") == "u" or apart:
        return None
    first = place - items.at(place - 1).is_a("determiner")
    start = first
    while items.at(start - 1).is_a(*TRAITS) and not items.at(start - 1).low.startswith("in "):
        start -= 1
    traits = tuple(items[start:first])
    start -= bool(traits) and items.at(start - 1).is_a("determiner")
    described = Description(number=number, span=items.span(place, at))
    return Mention(start, at, MentionKind.NAMED, traits=traits, description=described, is_person=is_person)


def _more_numbers(items: Words, place: int) -> Mention | None:
    at = place + 1 + (items.at(place + 1).low == "#")
    number, other = _number(items, at), ("lane", "number", "name", "body", "descriptor", "bound", "lanekind")
    if items.at(place).low not in word_set("and") or number is None or items.at(at + 1).is_a(*other):
        return None
    return Mention(at, at, MentionKind.NAMED, description=Description(number=number, span=items[at].span))


def _described(items: Words, place: int) -> Mention | None:
    if not is_head(items, place):
        return None
    first, last, article, described = read_group(items, place)
    is_plural = items[last].low.endswith("s") and items[last].is_a("body") and not described.names
    if (is_plural and items[last].low != "bus") or article.low in {"both", "two", "all"}:
        return Mention(first, last, MentionKind.BOTH, bodies=described.bodies)
    traits = tuple(item for item in items[first:place] if item.is_a(*TRAITS))
    kind = MentionKind.OTHER if described.is_other and not described.names else MentionKind.NAMED
    return Mention(first, last, kind, is_new=not described.is_definite, traits=traits, description=described)


def _take_driver(items: Words, mention: Mention) -> None:
    """Join "the driver of" before a name, and "'s driver" after it, to the name."""
    first, last = mention.first, mention.last
    if items.at(first - 1).low == "of" and items.at(first - 2).get("person") in {"driver", "someone"}:
        first -= 2
        while first and (
            items[first - 1].is_a("determiner", "number", "descriptor")
            or items[first - 1].low in {"year", "old", "-"}
            or items[first - 1].get("person") == "someone"
        ):
            first -= 1
        mention.first, mention.is_person = first, True
    owned = 1 + (items.at(last + 1).low == "'s")
    numbered = items.at(last + owned + 1).is_a("number") and mention.kind is MentionKind.NAMED and owned == 1
    if items.at(last + owned).get("person") == "driver" and not numbered:
        mention.last, mention.is_person = last + owned, True


def _pronoun(items: Words, place: int) -> Mention | None:
    item, after, before = items[place], items.at(place + 1), items.at(place - 1)
    kind, person = item.get("pronoun"), item.get("person")
    if item.is_a("insured"):
        is_self = item.get("insured") == "Self"
        return Mention(place, place, MentionKind.SELF if is_self else MentionKind.OTHER, is_person=not is_self)
    if kind == "self" and not (item.low == "i" and after.is_a("number")):
        return Mention(place, place, MentionKind.SELF, is_person=True)
    if kind == "own":
        owns = after.is_a("thing", "part", "flank", "hand")
        return Mention(place, place + after.is_a("thing"), MentionKind.SELF) if owns else None
    if kind == "other":
        return _other(items, place)
    if kind in {"former", "latter"}:
        return Mention(place, place, MentionKind.IT)
    if kind == "both":
        return _both(items, place)
    if before.verb is not None and before.verb.kind == "do" and after.is_a("hand") and kind in {"own", "its"}:
        if not items.at(place + 2).is_a("part", "flank", "hand"):
            return None  # "to make her left"
    if item.low == "her" and after.is_a("part", "flank", "hand", "lane", "road"):
        kind = "its"
    if kind in {"it", "one", "its"} and item.low not in {"this", "that"}:
        return Mention(place, place, MentionKind(kind), is_person=kind == "one")
    if item.get("thing") == "vehicles" and before.is_a("determiner"):
        return Mention(place - 1, place, MentionKind.BOTH)
    if (item.is_a("thing") and len(item.low) > 3) or (item.low == "one" and before.low in word_set("colours")):
        return _thing(items, place)
    if person == "other":
        return Mention(place, place, MentionKind.PERSON, is_person=True, is_new=True)
    if person in {"driver", "someone"} and len(item.low) > 2:
        is_new = before.get("determiner") == "a"
        first = place - before.is_a("determiner")
        return Mention(first, place, MentionKind.PERSON, is_person=True, is_new=is_new)
    return None


def _other(items: Words, place: int) -> Mention | None:
    last = place
    while (
        items.at(last + 1).is_a("thing")
        or items.at(last + 1).get("person") in {"driver", "someone"}
        or items.at(last + 1).low in word_set("one_of_them")
    ):
        last += 1
    if items[place].low in {"other", "another"} and last == place:
        return None
    return Mention(place, last, MentionKind.OTHER, is_person=items[last].is_a("person"))


def _both(items: Words, place: int) -> Mention | None:
    """Two vehicles by "both", but not in "both northbound lanes"; by "all" only before a verb."""
    item, after, next_one = items[place], items.at(place + 1), items.at(place + 2)
    taken = after.get("thing") == "vehicles" or after.low in word_set("both_of_them")
    goes = after.is_a("bound") and not next_one.is_a("lane", "road", "lanekind")
    of_road = after.is_a("road", "determiner", "junction", "lane", "compass", "hand") or (
        after.is_a("bound") and not goes
    )
    if taken or item.low not in {"both", "all"} or (item.low == "both" and not of_road):
        return Mention(place, place + taken, MentionKind.BOTH)
    return Mention(place, place, MentionKind.BOTH) if goes or after.is_a("auxiliary", "verb") else None


def _thing(items: Words, place: int) -> Mention | None:
    """One that is known by "the vehicle"; "a vehicle" and "the parked vehicle" may be another."""
    before = items.at(place - 1)
    if items.at(place + 1).is_a("collision"):
        return None  # "a single-vehicle event"
    if before.get("determiner") == "the":
        return Mention(place - 1, place, MentionKind.IT)
    if before.get("determiner") != "a" and not before.is_a("descriptor", *TRAITS):
        return None
    backs = range(place - 1, max(-1, place - 4), -1)
    first = next((back for back in backs if items[back].is_a("determiner")), place - 1)
    if items[place].low == "one" and items.at(first - 1).low == ",":
        return None  # "the other van, a white one"
    traits = tuple(each for each in items[first:place] if each.is_a(*TRAITS))
    is_new, marks = items[first].get("determiner") == "a", frozenset(each.low for each in traits)
    marks |= {before.low} & word_set("colours")
    described = Description(words="vehicle", span=items[place].span, is_definite=not is_new, marks=marks)
    return Mention(first, place, MentionKind.NAMED, is_new=is_new, traits=traits, description=described)
