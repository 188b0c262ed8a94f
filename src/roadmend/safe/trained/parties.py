"""Who took part in a crash, as the trained network finds it in the bare text, and whom the rules lack put into their cast."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from roadmend.safe.claims import CastMember
from roadmend.safe.reading.reader import SummaryClaims
from roadmend.safe.trained.crash_network import CrashNetwork
from roadmend.safe.trained.marked_text import Name, NamedCrash, mark_text, named_crash
from roadmend.safe.trained.outputs import SEATS

_PLAIN = 3  # most words of a name that a cast gives


@dataclass(frozen=True, slots=True)
class Party:
    """Somebody who took part, by the network.

    Attributes:
        places: where the text names them, each the characters from its start up to, not including, its end; in order.
        certainty: of the surest of these places, 0 to 1.
    """

    places: tuple[tuple[int, int], ...]
    certainty: float


@dataclass(frozen=True, slots=True)
class Recast:
    """What the rules made of a summary, with those whom they lack.

    Attributes:
        said: by the summary; its cast may have members more, of whom the rules claim nothing.
        crash: the text and where it names who took part, by their place among ``said.kept``.
    """

    said: SummaryClaims
    crash: NamedCrash


def find_parties(network: CrashNetwork, summary: str) -> list[Party]:
    """Who took part, in the order in which the text first names them."""
    shares = network.parties(mark_text(NamedCrash(summary, (), 0), network.pieces))
    _, spans = network.pieces.split(summary)
    found: dict[int, list[tuple[int, int, float]]] = {}
    last = 0
    for (start, end), row in zip(spans, shares[1:-1], strict=True):
        party = int(row.argmax())
        if party:
            places = found.setdefault(party, [])
            if party == last and places and not summary[places[-1][1] : start].strip():
                begin, _, share = places.pop()
                places.append((begin, end, max(share, float(row[party]))))
            else:
                places.append((start, end, float(row[party])))
        last = party
    rows = sorted(found.values(), key=lambda places: places[0][0])
    return [Party(tuple(each[:2] for each in places), max(each[2] for each in places)) for places in rows]


def is_numbered(said: SummaryClaims) -> bool:
    """Whether the text numbers vehicles that took part; the rules seldom miss a number, and no other party is looked for."""
    return any(said.text.spoken.roll.vehicles[place].description.number is not None for place in said.kept)


def recast(summary: str, said: SummaryClaims, parties: Sequence[Party], least: float) -> Recast:
    """Take the cast from the network where it is sure of more who took part than the rules have.

    Where it finds fewer it is not followed: of the texts by authors held out that costs more than it wins.

    Args:
        summary: the text.
        said: by the summary, as the rules have it.
        parties: as the network has it.
        least: certainty that the network needs of each party to be followed.
    """
    crash = named_crash(summary, said)
    if not len(said.kept) < len(parties) <= SEATS or min(each.certainty for each in parties) < least:
        return Recast(said, crash)
    members = _members(said, parties)
    cast, kept = [*said.cast], list[int]()
    for place, party in enumerate(parties):
        member = members.get(place)
        if member is None:
            member = len(cast)
            cast.append(_member(summary, party, cast))
        kept.append(member)
    changed = replace(said, cast=tuple(cast), kept=tuple(kept))
    return Recast(changed, _named(summary, changed, parties))


def _members(said: SummaryClaims, parties: Sequence[Party]) -> Mapping[int, int]:
    """Which member of the cast each party is, by whom the text names in the same places; the largest overlap first."""
    overlaps = np.zeros((len(parties), len(said.cast)))
    for place, party in enumerate(parties):
        for row in said.text.spoken.mentions:
            for each in row:
                if len(each.vehicles) == 1:
                    overlaps[place, each.vehicles[0]] += sum(
                        max(0, min(end, each.span.end) - max(start, each.span.start)) for start, end in party.places
                    )
    found = dict[int, int]()
    for flat in np.argsort(-overlaps, axis=None, kind="stable").tolist():
        place, member = divmod(flat, len(said.cast))
        if overlaps[place, member] <= 0:
            break
        if place not in found and member not in found.values():
            found[place] = member
    return found


def _member(summary: str, party: Party, cast: Sequence[CastMember]) -> CastMember:
    words = {" ".join(summary[start:end].lower().split()) for start, end in party.places}
    names = sorted((each for each in words if len(each.split()) <= _PLAIN), key=lambda name: (-len(name), name))
    return CastMember(max((each.number for each in cast), default=0) + 1, tuple(names), None)


def _named(summary: str, said: SummaryClaims, parties: Sequence[Party]) -> NamedCrash:
    """The text with the names of both, but where they differ those of the network."""
    names = [Name(start, end, (seat,)) for seat, party in enumerate(parties) for start, end in party.places]
    taken = np.zeros(len(summary), bool)
    for each in names:
        taken[each.start : each.end] = True
    rules = named_crash(summary, said).names
    return NamedCrash(
        summary, (*names, *(each for each in rules if not taken[each.start : each.end].any())), len(parties)
    )
