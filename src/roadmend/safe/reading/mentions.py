"""Where a text speaks of vehicles, and which vehicle each time: "V1", "a 2004 Honda Civic", "the pickup", "my car"."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from roadmend.safe.claims import Span
from roadmend.safe.reading.cast import Description, Roll
from roadmend.safe.reading.lexicon import BodySense, NameSense
from roadmend.safe.reading.tokens import Item, Sentence, name_senses

_MOST_VEHICLES = 9
_HEADLINE = 16  # words
_YEARS = range(1920, 2100)
_APPOSITION = 6  # words at most between two names of one vehicle
_REACH = 6  # words before a noun in which its article is looked for
_LETTERS = {"a": 1, "b": 2, "c": 3, "d": 4}
_BETWEEN = frozenset(
    {
        ",",
        "(",
        ")",
        "-",
        ":",
        "=",
        "#",
        "'s",
        "being",
        "called",
        "i",
        "e",
        "ie",
        "driving",
        "drove",
        "driven",
        "identified",
        "as",
        "case vehicle",
        "subject vehicle",
        "case",
        "subject",
        "vehicle",
    }
)


class MentionKind(StrEnum):
    """How a vehicle is called."""

    NAMED = "named"  # by number or description
    SELF = "self"  # "I", "my car"
    OTHER = "other"  # "the other driver"
    PERSON = "person"  # "the driver", "a woman"
    IT = "it"
    ONE = "one"  # "he", "they"
    POSSESSIVE = "possessive"  # "its", "his"
    BOTH = "both"


@dataclass(slots=True)
class Mention:
    """One place where a text speaks of vehicles.

    Attributes:
        first: its first word in the sentence.
        last: its last.
        span: in the summary.
        kind: how it is called.
        vehicles: which, by place in the cast; empty while open.
        is_new: whether its article says that it was not spoken of before.
        traits: words that go with it and say something of it: "northbound", "parked".
        description: of a described one.
        is_person: whether it is the driver that is spoken of.
        twin: the mention beside it that is of the same vehicle.
    """

    first: int
    last: int
    span: Span
    kind: MentionKind
    vehicles: tuple[int, ...] = ()
    is_new: bool = False
    traits: tuple[Item, ...] = ()
    description: Description | None = None
    is_person: bool = False
    twin: "Mention | None" = None


@dataclass(slots=True)
class Spoken:
    """The vehicles of a text and where it speaks of them, by sentence."""

    roll: Roll = field(default_factory=Roll)
    mentions: list[list[Mention]] = field(default_factory=list)


def find_mentions(sentences: Sequence[Sentence]) -> Spoken:
    """Find all mentions of a text, and name the vehicles that are called by number or description."""
    spoken = Spoken()
    found = [list(_mentions(sentence)) for sentence in sentences]
    numbers = sorted(
        {each.description.number for row in found for each in row if each.description and each.description.number}
    )
    spoken.roll.enrol(numbers)
    for sentence, row in zip(sentences, found, strict=True):
        _couple(sentence, row)
        _own(sentence, row)
        for mention in row:  # first, for a report may speak of "a 2004 Civic" before it gives it a number
            if mention.description is not None and mention.description.number is not None:
                mention.vehicles = spoken.roll.call(mention.description, is_new=False, is_headline=False)
    for sentence, row in zip(sentences, found, strict=True):
        is_headline = _is_headline(sentence, sentences)
        for mention in row:
            if mention.twin is not None and mention.twin.vehicles:
                mention.vehicles = mention.twin.vehicles
            if mention.vehicles:
                spoken.roll.latest = mention.vehicles[0]
            elif mention.description is not None:
                mention.vehicles = spoken.roll.call(mention.description, is_new=mention.is_new, is_headline=is_headline)
    _possess(found)
    own = spoken.roll.own()
    for sentence, row in zip(sentences, found, strict=True):
        _seat(sentence, row)
        for mention in row:
            if mention.kind is MentionKind.SELF:
                mention.vehicles = own
        spoken.mentions.append([each for each in row if each.kind is not MentionKind.SELF or each.vehicles])
    return spoken


def _is_headline(sentence: Sentence, sentences: Sequence[Sentence]) -> bool:
    """Whether it stands alone over a text, as a newspaper's headline does."""
    alone = sum(each.paragraph == sentence.paragraph for each in sentences) == 1
    return alone and sentence.paragraph == 0 and len(sentence.items) < _HEADLINE and len(sentences) > 1


def _own(sentence: Sentence, row: Sequence[Mention]) -> None:
    """Take the vehicle that the writer says to sit in for the writer's: "I was in the Civic"."""
    for one, other in itertools.pairwise(row):
        if one.kind is MentionKind.SELF and other.description is not None and not other.description.number:
            between = sentence.items[one.last + 1 : other.first]
            last = between[-1] if between else None
            if (
                last is not None
                and last.low in {"in", "driving", "drove", "drive", "own", "'s"}
                and len(between) < _REACH
            ):
                other.description = replace(other.description, is_own=True)


def _possess(found: Sequence[Sequence[Mention]]) -> None:
    """Give a "she" with whom a text begins the vehicle that it calls hers: "drifted into her Altima"."""
    rows = [(place, mention) for place, row in enumerate(found) for mention in row]
    hers = next(
        ((place, each) for place, each in rows if each.description is not None and each.description.is_theirs), None
    )
    if hers is None:
        return
    first = next((each for _, each in rows if each.description is not None), None)
    for place, mention in rows:
        early = first is None or mention.span.start < first.span.start
        if early and place <= hers[0] and mention.kind is MentionKind.ONE and not mention.vehicles:
            mention.vehicles = hers[1].vehicles


def _seat(sentence: Sentence, row: Sequence[Mention]) -> None:
    """Put a person into the vehicle that it is said to sit in: "he's in a Dodge Ram"."""
    for one, other in itertools.pairwise(row):
        if one.kind in {MentionKind.ONE, MentionKind.PERSON} and not one.vehicles and other.description is not None:
            between = sentence.items[one.last + 1 : other.first]
            if between and between[-1].low in {"in", "driving", "drove", "operating"} and len(between) <= 3:
                one.vehicles = other.vehicles


def _couple(sentence: Sentence, row: Sequence[Mention]) -> None:
    """Give two names of one vehicle that stand side by side one description: "Vehicle 1, a 2004 Honda Civic"."""
    named = [each for each in row if each.description is not None]
    for one, other in itertools.pairwise(named):
        between = sentence.items[one.last + 1 : other.first]
        assert one.description is not None and other.description is not None  # noqa: PT018
        numbers = {one.description.number, other.description.number}
        if (
            not (between and all(item.is_a("thing") for item in between) and None in numbers)
            and (len(between) > _APPOSITION or not _is_apposition(between, other))
        ) or None not in numbers:
            continue
        if numbers == {None} and (not other.is_new or one.description.contradicts(other.description)):
            continue
        merged = one.description.merged(other.description)
        one.description = other.description = merged
        other.is_new, other.twin = one.is_new, one


def _is_apposition(between: Sequence[Item], other: Mention) -> bool:
    if not between:
        return True
    is_copula = all(item.kinds.get("auxiliary") == "be" for item in between)
    has_mark = any(item.low in {",", "(", "-", ":", "="} for item in between)
    plain = all(item.low in _BETWEEN or item.is_a("thing", "descriptor") for item in between)
    if not has_mark and len(between) <= 2 and all(not item.kinds and item.low.isalpha() for item in between):
        return True  # "veh 1 unk pickup"
    return (is_copula and other.is_new) or (plain and has_mark)


def _mentions(sentence: Sentence) -> Iterator[Mention]:
    items, place = sentence.items, 0
    while place < len(items):
        mention = _numbered(items, place) or _described(items, place) or _pronoun(items, place)
        if mention is None:
            place += 1
            continue
        mention = _with_driver(items, mention)
        yield mention
        place = mention.last + 1
        while mention.description is not None and mention.description.number is not None:
            more = _more_numbers(items, place)  # "vehicles 1 and 2"
            if more is None:
                break
            yield more
            mention, place = more, more.last + 1


def _span(items: Sequence[Item], first: int, last: int) -> Span:
    return Span(items[first].span.start, items[last].span.end)


def _numbered(items: Sequence[Item], place: int) -> Mention | None:
    head = items[place]
    if not (head.is_a("thing") or head.kinds.get("person") == "driver" or head.low in {"car", "auto", "truck", "cars"}):
        return None
    at = place + 1
    while at < len(items) and items[at].low in {"#", "no", "number", "num", "nr", "-"}:
        at += 1
    if at >= len(items):
        return None
    number = items[at].kinds.get("number")
    if number is None and len(items[at].text) == 1 and items[at].text.isupper() and len(head.low) > 1:
        number = _LETTERS.get(items[at].low)
    following = items[at + 1] if at + 1 < len(items) else None
    if (
        not isinstance(number, int)
        or not 1 <= number <= _MOST_VEHICLES
        or (following is not None and following.is_a("lane", "time", "mph"))
    ):
        return None
    if items[at].low in {"a", "i"} and following is not None and following.is_a("name", "body", "descriptor"):
        return None
    if head.kinds.get("thing") == "u" or (len(head.low) == 1 and not (items[at].span.start - head.span.end <= 1)):
        return None
    first = place - 1 if place and items[place - 1].is_a("determiner") else place
    first, traits = _traits(items, first)
    is_person = head.kinds.get("person") == "driver"
    return Mention(
        first,
        at,
        _span(items, first, at),
        MentionKind.NAMED,
        traits=traits,
        description=Description(number=number, span=_span(items, place, at)),
        is_person=is_person,
    )


def _more_numbers(items: Sequence[Item], place: int) -> Mention | None:
    if place + 1 >= len(items) or items[place].low not in {"and", "&", "/", "+", ","}:
        return None
    at = place + 2 if items[place + 1].low == "#" and place + 2 < len(items) else place + 1
    number = items[at].kinds.get("number")
    following = items[at + 1] if at + 1 < len(items) else None
    if (
        not isinstance(number, int)
        or not 1 <= number <= _MOST_VEHICLES
        or (
            following is not None
            and following.is_a("lane", "number", "name", "body", "descriptor", "bound", "lanekind")
        )
    ):
        return None
    return Mention(
        at, at, items[at].span, MentionKind.NAMED, description=Description(number=number, span=items[at].span)
    )


def _traits(items: Sequence[Item], first: int) -> tuple[int, tuple[Item, ...]]:
    """What is said of a vehicle directly before its name: "northbound V1"."""
    place = first
    while (
        place
        and items[place - 1].is_a("bound", "oncoming", "parked", "stationary")
        and not items[place - 1].low.startswith("in ")
    ):
        place -= 1
    traits = tuple(items[place:first])
    if place and traits and items[place - 1].is_a("determiner"):
        place -= 1
    return place, traits


def _described(items: Sequence[Item], place: int) -> Mention | None:
    if not _is_head(items, place):
        return None
    last = place
    names: list[NameSense] = []
    bodies: list[tuple[BodySense, Span]] = []
    at = place
    while at < len(items) and (
        _is_head(items, at)
        or (
            _is_filler(items, at)
            and any(
                _is_head(items, further)
                for further in range(at + 1, min(at + 4, len(items)))
                if all(_is_filler(items, between) for between in range(at, further))
            )
        )
    ):
        item = items[at]
        if _is_head(items, at):
            last = at
            chosen = _chosen(item, names)
            if chosen is not None and not (item.is_a("body") and names):
                names.append(chosen)
            elif item.is_a("body"):
                bodies.append((item.kinds["body"], item.span))
        at += 1
    first, determiner = place, None
    for back in range(place - 1, max(-1, place - 1 - _REACH), -1):
        item = items[back]
        if item.is_a("determiner") or item.kinds.get("pronoun") in {"own", "its", "other"} or item.low == "her":
            first, determiner = back, item
            break
        if (
            item.is_a("preposition", "conjunction", "auxiliary", "relative", "person")
            or item.low in ",.():;-/"
            or item.low == "'s"
        ):
            break
        if (
            item.is_a("verb")
            and not item.is_a("descriptor", "parked", "stationary", "bound", "oncoming")
            and item.kinds["verb"].form not in {"ing", "both", "participle"}
        ):
            break
    if determiner is None:
        while first and (
            items[first - 1].is_a("bound", "parked", "stationary")
            or items[first - 1].kinds.get("number") in _YEARS
            or (items[first - 1].is_a("descriptor") and not items[first - 1].is_a("verb"))
        ):
            first -= 1
    before = items[first:place]
    year = next((item.kinds["number"] for item in before if item.kinds.get("number") in _YEARS), None)
    traits = tuple(item for item in before if item.is_a("bound", "oncoming", "parked", "stationary"))
    span = _span(items, place, last)
    words = _span(items, first, last)
    is_plural = (
        items[last].low.endswith("s") and items[last].is_a("body") and items[last].low[:-1] != "bu" and not names
    )
    if is_plural or (determiner is not None and determiner.low in {"both", "two", "all"}):
        return Mention(first, last, words, MentionKind.BOTH)
    owner = determiner.kinds.get("pronoun") if determiner is not None else None
    low = " ".join(item.low for item in items[place : last + 1])
    article = determiner.kinds.get("determiner") if determiner is not None else None
    is_other = owner == "other" or any(item.kinds.get("pronoun") == "other" for item in before)
    is_new = (
        article in {"a", "some"} or (determiner is None and bool(names)) or (is_other and "another" in _low(before))
    )
    place_words = {item.low for item in before}
    description = Description(
        year=year,
        names=tuple(names),
        bodies=tuple(bodies),
        is_own=owner == "own",
        is_theirs=owner in {"its", "one"},
        is_other=is_other,
        words=low,
        span=span,
        is_definite=not is_new,
        marks=frozenset(
            place_words & {"first", "second", "third", "lead", "last", "middle"}
            | {item.low for item in before if item.low in _COLOURS or item.is_a("parked")}
        ),
    )
    kind = MentionKind.OTHER if is_other and not names else MentionKind.NAMED
    return Mention(first, last, words, kind, is_new=is_new, traits=traits, description=description)


_COLOURS = frozenset(
    [
        "black",
        "white",
        "silver",
        "grey",
        "gray",
        "red",
        "blue",
        "green",
        "tan",
        "gold",
        "brown",
        "yellow",
        "orange",
        "beige",
        "maroon",
    ]
)


def _low(items: Sequence[Item]) -> str:
    return " ".join(item.low for item in items)


def _is_head(items: Sequence[Item], place: int) -> bool:
    item = items[place]
    before = items[place - 1] if place else None
    after = items[place + 1] if place + 1 < len(items) else None
    if item.is_a("body") and not item.is_a("axlewords"):
        if (
            before is not None
            and before.kinds.get("number") in range(2, 20)
            and not (place > 1 and (items[place - 2].is_a("thing") or items[place - 2].low == "#"))
            and (after is None or not after.is_a("name", "body"))
        ):
            return False  # "a 3-car crash"
        if item.low == "trailer" and (
            before is None or not (before.kinds.get("determiner") == "the" or before.low == "'s")
        ):
            return False  # a truck's, not a vehicle of its own
        if item.is_a("verb") and (before is None or not before.is_a("determiner", "descriptor", "name", "number")):
            return False  # "to crossover the road"
        is_stop = (
            item.low in {"bus", "cab", "coach", "tractor", "truck", "car", "compact", "utility", "van", "auto"}
            and after is not None
            and (
                after.low
                in {
                    "stop",
                    "lane",
                    "pole",
                    "park",
                    "wash",
                    "accident",
                    "crash",
                    "company",
                    "insurance",
                    "shelter",
                    "driver",
                    "drivers",
                    "repair",
                    "seat",
                    "keys",
                }
                or after.is_a("object")
            )
        )
        return not is_stop
    if not item.is_a("name"):
        return False
    if after is not None and after.is_a("road") and not after.is_a("body") and not item.low[-1].isdigit():
        return False
    if item.is_a("mph") or (after is not None and after.is_a("mph", "time")):
        return False
    if not all(sense.is_everyday for sense in name_senses(item)) and not item.is_a("verb", "bound", "weather"):
        is_street = (
            before is not None
            and before.low in {"on", "along", "onto"}
            and len(name_senses(item))
            and item.low.isalpha()
            and name_senses(item)[0].model is None
        )
        return not is_street
    if before is not None and (
        before.kinds.get("number") in _YEARS
        or (before.is_a("name") and _is_head(items, place - 1) and (_joins(before, item) or item.low.isdigit()))
    ):
        return True
    if (
        after is not None
        and after.is_a("body")
        and not item.is_a(
            "descriptor", "verb", "preposition", "determiner", "part", "hand", "number", "lanekind", "oncoming"
        )
        and item.text[:1].isupper()
    ):
        return True
    is_shown = (
        item.text[:1].isupper()
        and not item.text.isupper()
        and not item.is_a("number", "preposition", "hand", "bound", "compass")
    )
    led = before is not None and (
        before.is_a("determiner")
        or before.kinds.get("pronoun") in {"own", "its", "other"}
        or before.low in {"(", "descriptor"}
    )
    return is_shown and led and not item.is_a("lane", "road")


def _joins(make: Item, model: Item) -> bool:
    makes = {sense.make for sense in name_senses(make)}
    return any(sense.make in makes for sense in name_senses(model))


def _is_filler(items: Sequence[Item], place: int) -> bool:
    item = items[place]
    return (
        (
            item.is_a("descriptor")
            or item.kinds.get("number") in range(10)
            or (item.text[:1].isupper() and not item.kinds)
        )
        and not item.is_a("preposition", "auxiliary", "conjunction")
        and not (item.is_a("verb") and not item.is_a("body"))
    )


def _chosen(item: Item, names: Sequence[NameSense]) -> NameSense | None:
    found = name_senses(item)
    if not found:
        return None
    makes = {name.make for name in names}
    same = [sense for sense in found if sense.make in makes]
    return (same or list(found))[0] if same or not names else None


def _with_driver(items: Sequence[Item], mention: Mention) -> Mention:
    """Join "the driver of" before a name, and "'s driver" after it, to the name."""
    first = mention.first
    if first >= 2 and items[first - 1].low == "of" and items[first - 2].kinds.get("person") in {"driver", "someone"}:
        first -= 2
        while first and (
            items[first - 1].is_a("determiner", "number", "descriptor")
            or items[first - 1].low in {"year", "old", "-"}
            or items[first - 1].kinds.get("person") == "someone"
        ):
            first -= 1
        mention.first, mention.is_person = first, True
    last = mention.last
    if last + 2 < len(items) and items[last + 1].low == "'s" and items[last + 2].kinds.get("person") == "driver":
        mention.last, mention.is_person = last + 2, True
    elif (
        last + 1 < len(items)
        and items[last + 1].kinds.get("person") == "driver"
        and mention.kind is not MentionKind.NAMED
    ) or (
        last + 1 < len(items)
        and items[last + 1].kinds.get("person") == "driver"
        and mention.description is not None
        and not (last + 2 < len(items) and items[last + 2].is_a("number"))
    ):
        mention.last, mention.is_person = last + 1, True
    mention.span = _span(items, mention.first, mention.last)
    return mention


def _pronoun(items: Sequence[Item], place: int) -> Mention | None:
    item = items[place]
    here = item.span
    kind = item.kinds.get("pronoun")
    after = items[place + 1] if place + 1 < len(items) else None
    if item.is_a("insured"):
        if item.kinds["insured"] == "Self":
            return Mention(place, place, here, MentionKind.SELF, description=None)
        return Mention(place, place, here, MentionKind.OTHER, is_person=True)
    if kind == "self" and not (item.low == "i" and after is not None and after.is_a("number")):
        return Mention(place, place, here, MentionKind.SELF, is_person=True)
    if kind == "own":
        is_thing = after is not None and after.is_a("thing")
        return (
            Mention(place, place + is_thing, _span(items, place, place + is_thing), MentionKind.SELF)
            if is_thing or (after is not None and _is_part(after))
            else None
        )
    if kind == "other":
        last = place
        while last + 1 < len(items) and (
            items[last + 1].is_a("thing")
            or items[last + 1].kinds.get("person") in {"driver", "someone"}
            or items[last + 1].low in {"one", "party", "'s", "guy"}
        ):
            last += 1
        if item.low in {"other", "another"} and last == place:
            return None
        return Mention(place, last, _span(items, place, last), MentionKind.OTHER, is_person=items[last].is_a("person"))
    if kind == "both":
        last = (
            place + 1
            if after is not None
            and (after.kinds.get("thing") == "vehicles" or after.low in {"drivers", "vehicles", "cars", "trucks"})
            else place
        )
        return (
            Mention(place, last, _span(items, place, last), MentionKind.BOTH)
            if item.low not in {"both", "all"}
            or (item.low == "all" and after is not None and after.is_a("bound", "auxiliary", "verb"))
            or last > place
            or after is None
            or (
                not after.is_a("road", "determiner", "junction", "lane", "compass", "hand")
                and not (
                    after.is_a("bound") and place + 2 < len(items) and items[place + 2].is_a("lane", "road", "lanekind")
                )
            )
            else None
        )
    if item.low == "her" and after is not None and (_is_part(after) or after.is_a("lane", "road")):
        kind = "its"
    if kind in {"it", "one", "its"}:
        return (
            Mention(
                place,
                place,
                here,
                {"it": MentionKind.IT, "one": MentionKind.ONE, "its": MentionKind.POSSESSIVE}[kind],
                is_person=kind == "one",
            )
            if item.low not in {"this", "that"}
            else None
        )
    if item.kinds.get("thing") == "vehicles" and place and items[place - 1].is_a("determiner"):
        return Mention(place - 1, place, _span(items, place - 1, place), MentionKind.BOTH)
    if item.is_a("thing") and len(item.low) > 3 and place and items[place - 1].kinds.get("determiner") == "the":
        return Mention(place - 1, place, _span(items, place - 1, place), MentionKind.IT)
    if (
        item.is_a("thing")
        and len(item.low) > 3
        and place
        and (
            items[place - 1].kinds.get("determiner") == "a"
            or items[place - 1].is_a("parked", "stationary", "oncoming", "bound", "descriptor")
        )
    ):
        first = next(
            (back for back in range(place - 1, max(-1, place - 4), -1) if items[back].is_a("determiner")), place - 1
        )
        traits = tuple(each for each in items[first:place] if each.is_a("bound", "oncoming", "parked", "stationary"))
        is_new = items[first].kinds.get("determiner") == "a"
        return Mention(
            first,
            place,
            _span(items, first, place),
            MentionKind.NAMED,
            is_new=is_new,
            traits=traits,
            description=Description(
                words="vehicle", span=here, is_definite=not is_new, marks=frozenset(each.low for each in traits)
            ),
        )
    if item.kinds.get("person") == "other":
        return Mention(place, place, here, MentionKind.PERSON, is_person=True, is_new=True)
    if item.kinds.get("person") in {"driver", "someone"} and len(item.low) > 2:
        first = place - 1 if place and items[place - 1].is_a("determiner") else place
        return Mention(
            first,
            place,
            _span(items, first, place),
            MentionKind.PERSON,
            is_person=True,
            is_new=items[first].kinds.get("determiner") == "a",
        )
    return None


def _is_part(item: Item) -> bool:
    return item.is_a("part", "flank", "hand")
