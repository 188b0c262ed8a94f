"""Who sits in which vehicle: "she was driving a Kia", "a man in a Ram", "I was in the Civic", "Ortiz's Ford"."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from roadmend.safe.reading.cast import Description
from roadmend.safe.reading.clauses import STRIKES
from roadmend.safe.reading.groups import NounGroup
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.structure import Structure

PEOPLE = frozenset({MentionKind.PERSON, MentionKind.ONE, MentionKind.SELF})
_OPERATES = frozenset({"drive", "operate", "ride", "own"})
_LOADED = frozenset({"with", "pulling", "hauling", "towing", "carrying"})
_IN = frozenset({"in", "driving", "operating", "aboard", "riding", "with", "inside", "wheel of", "behind the wheel of"})


@dataclass(slots=True)
class Seats:
    """Who sits where in a text.

    Attributes:
        partner: by a mention's id: what that person sits in, who sits in that vehicle, or what has that load.
        named: by the id of a vehicle's mention: the name of who sits in it.
    """

    partner: dict[int, Mention] = field(default_factory=dict)
    named: dict[int, str] = field(default_factory=dict)


def seats_of(structures: Sequence[Structure], found: Sequence[Sequence[Mention]]) -> Seats:
    """Put people into vehicles, as far as sentences say so.

    Args:
        structures: of the sentences of a text.
        found: mentions of each sentence; what turns out to be a load loses its description.
    """
    seats = Seats()
    for structure, row in zip(structures, found, strict=True):
        groups = {id(group.mention): group for group in structure.groups}
        for mention in row:
            group = groups.get(id(mention))
            if group is not None and mention.description is not None and not mention.is_person:
                _seat(seats, structure, mention, mention.description, group.top)
    return seats


def _seat(seats: Seats, structure: Structure, mention: Mention, described: Description, top: int) -> None:
    lead = structure.items.at(mention.first - 1)
    if lead.low in _LOADED and (carrier := _carrier(structure, mention, top)) is not None:
        mention.description = Description(words=described.words, span=described.span)
        seats.partner[id(mention)] = carrier
        return
    name = _name(structure, mention, described, top)
    if name:
        seats.named[id(mention)] = name
    group = _person(structure, mention, top)
    who = group.mention if group is not None else None
    if who is None or who is mention:
        return
    is_me = who.kind is MentionKind.SELF and described.is_theirs and not structure.items[who.first].is_a("insured")
    is_me &= structure.items.at(who.last + 1).low not in word_set("and")  # "me and Jake, in his Ford"
    numbered = who.number is not None and lead.low != "with" and not mention.number
    if (who.kind in PEOPLE and not is_me) or numbered:
        seats.partner[id(who)] = mention
        seats.partner.setdefault(id(mention), who)


def _person(structure: Structure, mention: Mention, top: int) -> NounGroup | None:
    """The noun group of who sits in a vehicle, or whose it is."""
    lead = structure.items.at(mention.first - 1)
    owner = structure.group(mention.first - 2) if lead.low == "'s" and mention.first > 1 else None
    if owner is not None:
        return owner
    at, arc = structure.owner(top), structure.tree[top]
    if at is not None and arc.head == at and arc.relation in {"dobj", "attr"}:
        is_named = arc.relation == "attr" and mention.is_new
        return structure.subject(at) if is_named or _operates(structure, at) else None
    beside = structure.group(mention.first - 2) if lead.low == "in" else None
    if beside is not None and beside.mention is not None and beside.mention.kind is MentionKind.PERSON:
        return beside  # "that girl in the Focus", however the parser reads it
    return _sitter(structure, top, at) if lead.low in _IN and not _is_elsewhere(structure, top) else None


def _name(structure: Structure, mention: Mention, described: Description, top: int) -> str:
    """The person whom a text calls by name and puts into a vehicle: "Ortiz, northbound in her Corolla", "Kopp's SUV"."""
    items, lead = structure.items, structure.items.at(mention.first - 1)
    place = mention.first - 2 if lead.low == "'s" else structure.doer(top)
    seated = lead.low in _IN - {"with"} and not _is_elsewhere(structure, top)
    at = structure.owner(top)
    drives = at is not None and structure.tree[top].head == at and _operates(structure, at)
    if place is None or not (lead.low == "'s" or seated or drives or described.is_theirs):
        return ""
    item = items.at(place)
    road = items.at(place + 1).is_a("road", "lane", "junction")
    return item.low if item.is_name and not item.kinds and item.low.isalpha() and not road else ""


def _carrier(structure: Structure, mention: Mention, top: int) -> Mention | None:
    """The vehicle that has a load or a trailer: "a tractor with a flatbed"."""
    if mention.first > top or structure.items[mention.first].get("determiner") == "the":
        return None
    above = structure.group(structure.tree[structure.tree[top].head].head)
    one = above.mention if above is not None else None
    return one if one is not None and one.description is not None and not one.is_person else None


def _sitter(structure: Structure, top: int, at: int | None) -> NounGroup | None:
    """Who is in a vehicle: the person on whom "in" hangs, else who does what the clause says."""
    direct = structure.group(structure.tree[structure.tree[top].head].head)
    if direct is not None and direct.mention is not None and direct.mention.kind in PEOPLE:
        return direct
    if at is not None:
        return structure.subject(at)
    return next((each for each in reversed(structure.groups) if each.last < top and each.mention is not None), None)


def _operates(structure: Structure, at: int) -> bool:
    verb = structure.items[at].verb
    return verb is not None and verb.lemma in _OPERATES and verb.kind != "follow"  # "I drive behind an Astra"


def _is_elsewhere(structure: Structure, top: int) -> bool:
    """Whether "with" or "in" a vehicle says that one met it, not that one sits in it."""
    at = structure.owner(top)
    verb = structure.items[at].verb if at is not None else None
    return verb is not None and verb.kind in STRIKES | {"collide", "see", "say"}
