"""People who are called by name or by what they are, and the vehicle of each: "Mr. Kowalski ... his Tacoma"."""

from collections.abc import Iterator, Sequence

from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.tokens import Item, Sentence, Words

_REACH = 14  # words between a person and the vehicle of that person


def seat_by_name(sentences: Sequence[Sentence], found: Sequence[list[Mention]]) -> None:
    """Add the mentions of people by their names, and let each stand for the vehicle that the text gives to that person."""
    names: dict[str, tuple[int, ...]] = {}
    for sentence, row in zip(sentences, found, strict=True):
        for _, last in _groups(sentence.items, row):
            key = sentence.items[last].low
            vehicles = names.get(key) or _vehicle_of(sentence.items, row, last)
            if vehicles:
                names.setdefault(key, vehicles)
    for sentence, row in zip(sentences, found, strict=True):
        for first, last in _groups(sentence.items, row) if names else ():
            vehicles = names.get(sentence.items[last].low, ())
            if vehicles:
                row.append(_person(sentence.items, first, last, vehicles))
        row.sort(key=lambda each: each.first)


def seat_by_role(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> None:
    """Let "the nurse" be the one whom the text has put into a vehicle before."""
    roles: dict[str, tuple[int, ...]] = {}
    for sentence, row in zip(sentences, found, strict=True):
        for mention in row:
            item = sentence.items[mention.last]
            if mention.kind is not MentionKind.PERSON or item.get("person") not in {"someone", "other"}:
                continue
            if not mention.vehicles:
                mention.vehicles = roles.get(item.low, ()) if not mention.is_new else ()
            if not mention.vehicles:
                mention.vehicles = _vehicle_of(sentence.items, row, mention.last)
            if mention.vehicles:
                roles.setdefault(item.low, mention.vehicles)


def _person(items: Words, first: int, last: int, vehicles: tuple[int, ...]) -> Mention:
    return Mention(first, last, MentionKind.PERSON, items.span(first, last), vehicles, is_person=True)


def _groups(items: Words, row: Sequence[Mention]) -> Iterator[tuple[int, int]]:
    """Names of people: a title and what follows it, or words with capitals that mean nothing else."""
    taken = {place for each in row for place in range(each.first, each.last + 1)}
    place = 0
    while place < len(items):
        titled = items[place].low in word_set("titles")
        last = place + titled
        while last < len(items) and last not in taken and items[last].low == ".":
            last += 1
        start = last
        while last < len(items) and last not in taken and _is_surname(items[last], titled=titled and last == start):
            last += 1
        if last > start and not _is_elsewhere(items, place, last):
            yield place, last - 1
        place = max(last, place + 1)


def _is_surname(item: Item, *, titled: bool) -> bool:
    is_shown = (
        item.is_name and item.low.isalpha() and item.low not in word_set("no_names") and (len(item.low) > 2 or titled)
    )
    return is_shown and (titled or not item.kinds)


def _is_elsewhere(items: Words, first: int, last: int) -> bool:
    """Whether it is the name of a road or a place."""
    titled = items[first].low in word_set("titles")
    after, before = items.at(last), items.at(first - 1)
    placed = before.is_a("preposition", "determiner", "road", "corner") and before.low not in word_set("by_person")
    return after.is_a("road", "junction") or (placed and not titled)


def _vehicle_of(items: Words, row: Sequence[Mention], last: int) -> tuple[int, ...]:
    """The vehicle that a sentence gives to a person: "Ortiz, northbound in her Corolla", "Kowalski's Explorer"."""
    after = [each for each in row if each.first > last and each.description is not None and each.vehicles]
    if not after or after[0].first - last > _REACH:
        return ()
    vehicle, lead = after[0], items.at(after[0].first - 1)
    between = items.cut(last + 1, vehicle.first)
    if between and between[0].low == "'s" and len(between) == 1:
        return vehicle.vehicles[:1]
    seated = lead.low in word_set("sits_in") - {"'s"} or lead.low in {"of", "aboard", "behind"}
    is_wheel = lead.low != "of" or between.says({"wheel", "driver", "control", "controls"})
    theirs = vehicle.description is not None and vehicle.description.is_theirs
    others = [each for each in row if last < each.first < vehicle.first and each.vehicles]
    if others or (between.has("conjunction") and not theirs):
        return ()
    return vehicle.vehicles[:1] if (seated and is_wheel) or theirs else ()
