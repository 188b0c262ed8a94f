"""Names of vehicles and of those who drive them, one by one: "V1", "a 2004 Honda Civic", "the pickup", "my car", "she"."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum

from roadmend.safe.claims import Span
from roadmend.safe.reading.cast import Description
from roadmend.safe.reading.heads import TRAITS, is_head, read_group
from roadmend.safe.reading.lexicon import BodySense, word_set
from roadmend.safe.reading.tokens import Item, Words

_MOST_VEHICLES = 9
_PADDED = frozenset({"01", "02", "03", "04"})
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
        speaker: of an "I", the numbered driver whose words it stands in, where the text tells that.
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
    speaker: "Mention | None" = None
    bodies: tuple[tuple[BodySense, Span], ...] = ()

    @property
    def number(self) -> int | None:
        """The report's, of a numbered one."""
        return self.description.number if self.description is not None else None


def names_in(sentences: Iterable[Words]) -> frozenset[str]:
    """The makes and models by which a text calls its vehicles somewhere, and all letters where it does so by a letter."""
    found: set[str] = set()
    for items in sentences:
        for place, item in enumerate(items):
            if item.is_a("name") and _is_telling(items, place) and is_head(items, place):
                found.add(item.low)
            mention = _numbered(items, place)
            if mention is not None and items[mention.last].low in _LETTERS:
                found |= {"A", "B", "C"}
    return frozenset(found)


def _is_telling(items: Words, place: int) -> bool:
    """Whether a name is one wherever it stands: a word, or the figures of a model behind its make: "XC60"."""
    name = items[place].low
    return name.isalpha() or (items.at(place - 1).is_a("name") and not name.isdigit())


def mentions_of(items: Words, known: Collection[str] = ()) -> Iterator[Mention]:
    """All mentions of a sentence, in their order.

    Args:
        items: its words.
        known: names of vehicles from elsewhere in the text.
    """
    place = 0
    while place < len(items):
        mention = (
            _numbered(items, place)
            or _lettered(items, place, known)
            or _described(items, place, known)
            or _pronoun(items, place)
        )
        if mention is None:
            place += 1
            continue
        if _is_denied(items, mention):
            place = mention.last + 1
            continue
        _take_driver(items, mention)
        after = items.at(mention.last + 1)
        ends = items.at(mention.last + 2).low in word_set("trait_ends") or items.at(mention.last + 2).is_a("negation")
        if (
            after.is_a("bound")
            and not after.low.endswith(("ward", "wards"))
            and ends
            and mention.description is not None
        ):
            mention.traits = (*mention.traits, after)  # "struck U2 EB"
        while mention is not None:
            mention.span = items.span(mention.first, mention.last)
            yield mention
            place = mention.last + 1
            mention = _more_numbers(items, place) if mention.number is not None else None  # "vehicles 1 and 2"


def _is_denied(items: Words, mention: Mention) -> bool:
    """Whether a vehicle is said not to have been there: "no other car", "not a motorcycle"."""
    lead = items.at(mention.first - 1).low
    is_else = lead == "not" and mention.description is not None and not mention.is_person
    return mention.number is None and (is_else or "no" in {items.at(mention.first).low, lead})


def _number(items: Words, place: int) -> int | None:
    number = items.at(place).get("number")
    return number if isinstance(number, int) and 1 <= number <= _MOST_VEHICLES else None


def _numbered(items: Words, place: int) -> Mention | None:
    head = items[place]
    ordinal = items.at(place - 1).get("ordinal") or (2 if items.at(place - 1).low == "the second" else None)
    if head.low in {"vehicle", "unit"} and ordinal and "the" in {items.at(place - 2).low, items.at(place - 1).low[:3]}:
        described = Description(number=ordinal, span=items.span(place - 1, place))
        return Mention(place, place, MentionKind.NAMED, description=described)
    if head.low in _PADDED or (
        head.low == "#" and _number(items, place + 1) and not items.at(place - 1).is_a("thing", "person", "lane")
    ):
        at = place + (head.low == "#")
        aside = (
            items.at(place - 1).low in {":", "/", "$"}
            or items.at(at + 1).low in {":", "/"}
            or (items.at(at + 1).is_a("name") and head.low != "#")
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
        is_article = following.is_a("name", "body", "descriptor") and (
            head.text.isupper() or (label.low == "a" and at == place + 2)
        )
        number = _LETTERS.get(label.low) if not is_article else None
    apart = len(head.low) == 1 and label.span.start - head.span.end > 1
    if number is None or following.is_a("lane", "time", "mph") or head.get("thing") == "u" or apart:
        return None
    first = place - items.at(place - 1).is_a("determiner")
    start = first
    while items.at(start - 1).is_a(*TRAITS) and not items.at(start - 1).low.startswith("in "):
        start -= 1
    traits = tuple(items[start:first])
    start -= bool(traits) and items.at(start - 1).is_a("determiner")
    bodies = ((head.get("body"), head.span),) if head.low == "cmv" else ()
    described = Description(number=number, bodies=bodies, span=items.span(place, at))
    return Mention(start, at, MentionKind.NAMED, traits=traits, description=described, is_person=is_person)


def _lettered(items: Words, place: int, known: Collection[str]) -> Mention | None:
    """A letter alone, where a text calls its vehicles by letters: "B is a Sierra", "into the rear of A"."""
    item, before, after = items[place], items.at(place - 1), items.at(place + 1)
    if (
        item.low not in _LETTERS
        or item.text not in known
        or before.is_a("road", "thing", "person", "part", "insured")
        or before.low == "-"
    ):
        return None
    ends = after.low in {"", "'s", ",", ";", ")", ":", "'"} or after.is_a("auxiliary", "verb", "bound")
    is_person = after.get("person") == "driver"
    if not (ends or is_person) or (item.low == "a" and after.is_a("verb") and not before.is_a("preposition")):
        return None
    described = Description(number=_LETTERS[item.low], span=item.span)
    return Mention(place, place + is_person, MentionKind.NAMED, description=described, is_person=is_person)


def _more_numbers(items: Words, place: int) -> Mention | None:
    at = place + 1 + (items.at(place + 1).low == "#")
    if items.at(place).low == "+" and not items.at(at + 1).kinds:
        return None  # "operator B + 4 pax"
    number, other = _number(items, at), ("lane", "number", "name", "body", "descriptor", "bound", "lanekind")
    if items.at(place).low not in word_set("and") or number is None or items.at(at + 1).is_a(*other):
        return None
    return Mention(at, at, MentionKind.NAMED, description=Description(number=number, span=items[at].span))


def _described(items: Words, place: int, known: Collection[str]) -> Mention | None:
    if not is_head(items, place, known):
        return None
    if items.at(place - 1).low == "a" and items.at(place - 2).low in word_set("tows") and not items[place].is_a("name"):
        return None  # "a Mack pulling a reefer"
    if items.at(place - 1).low == "/" and items.at(place - 2).low == "w" and items[place].is_a("body"):
        return None  # "a Mack w/ tanker"
    first, last, article, described = read_group(items, place)
    again = items.at(last + 1).low in word_set("named_vehicle") and not items.at(last + 2).is_a("number")
    last += bool(described.names) and again  # "the Honda vehicle"
    is_plural = items[last].low.endswith("s") and items[last].is_a("body") and not described.names
    is_plural &= not (article.get("pronoun") in {"own", "its"} and items.at(last + 1).is_a("part"))  # "my trucks grill"
    if (is_plural and not items[last].low.endswith("bus")) or article.low in {"both", "two", "all"}:
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
        is_self = item.get("insured") == "Self" and before.low != "your"
        return Mention(place, place, MentionKind.SELF if is_self else MentionKind.OTHER, is_person=not is_self)
    if kind == "self" and not (item.low in {"i", "us"} and after.is_a("number")):
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
    turns = before.verb is not None and before.verb.kind == "do" and after.is_a("hand") and kind in {"own", "its"}
    if turns and not items.at(place + 2).is_a("part", "flank", "hand"):
        return None  # "to make her left"
    if item.low == "her" and after.is_a("part", "flank", "hand", "lane", "road"):
        kind = "its"
    if kind in {"it", "one", "its"} and item.low not in {"this", "that"}:
        owns = kind == "its" and after.get("thing") == "vehicle" and len(after.low) > 1  # "the front of his vehicle"
        return Mention(place, place + owns, MentionKind(kind), is_person=kind == "one" or item.low in {"his", "her"})
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
