"""Noun groups that name a vehicle, or a part of one, each as one thing: "V1's left side", "the front of the van"."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.parts import NamedPart, read_part
from roadmend.safe.reading.tokens import Words


@dataclass(frozen=True, slots=True)
class NounGroup:
    """A noun group that names a vehicle, or a part of one.

    Attributes:
        first: its first word in the sentence.
        last: its last.
        top: the word that stands for it in the sentence's tree.
        mention: of the vehicle; None where only a part is named.
        part: that is named.
        is_place: whether it is "V2's lane": somebody's, but not somebody.
    """

    first: int
    last: int
    top: int
    mention: Mention | None
    part: NamedPart | None
    is_place: bool = False


def groups_of(items: Words, mentions: Sequence[Mention]) -> list[NounGroup]:
    """The noun groups of a sentence that name vehicles and their parts, in their order."""
    starts = {mention.first: mention for mention in mentions}
    found: list[NounGroup] = []
    place = 0
    while place < len(items):
        group = _owner(items, starts[place]) if place in starts else _part(items, place, starts)
        if group is not None:
            found.append(group)
        place = group.last + 1 if group is not None else place + 1
    return found


def _owner(items: Words, mention: Mention) -> NounGroup:
    """A mention with the part of it that is named after it: "V1's left side", "its front"."""
    first, last = mention.first, mention.last
    is_short = mention.kind in {MentionKind.ONE, MentionKind.IT, MentionKind.SELF} and first == last
    owned = items.at(last + 1).low == "'s" and not is_short  # "she's" is "she is"
    is_own = items[first].get("pronoun") == "own"
    may_own = owned or is_own or mention.kind is MentionKind.POSSESSIVE or mention.description is not None
    part = read_part(items, last + 1 + owned, is_led=True) if may_own else None
    if part is not None:
        return NounGroup(first, part[1], part[1], mention, part[0])
    if mention.kind is MentionKind.POSSESSIVE and items.at(last + 1).get("person") == "driver":
        return NounGroup(first, last + 1, last + 1, mention, None)
    return NounGroup(
        first, last + owned, last, mention, None, owned or (mention.kind is MentionKind.POSSESSIVE and first == last)
    )


def _part(items: Words, place: int, starts: Mapping[int, Mention]) -> NounGroup | None:
    led = items[place].is_a("determiner") and (place + 1) not in starts
    found = read_part(items, place + led, is_led=led)
    if found is None:
        return None
    part, last = found
    owner = starts.get(last + 2)
    if owner is not None and items.at(last + 1).low == "of":
        return NounGroup(place, owner.last, owner.last, owner, part)
    return NounGroup(place, last, last, None, part)
