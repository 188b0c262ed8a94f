"""The text of a crash as the network takes it: pieces of words, each with a mark that says which vehicle it names."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.safe.reading.reader import SummaryClaims
from roadmend.safe.trained.compass_words import turn_text
from roadmend.safe.trained.outputs import SEATS
from roadmend.safe.trained.word_pieces import WordPieces

NOBODY, SOMEBODY_ELSE = 0, SEATS + 1  # marks: of what names no vehicle, and of what names one that took no part
MARKS = SEATS + 2
_SHARED = 0.3  # of the weight of a name is left to one of several vehicles that it stands for


@dataclass(frozen=True, slots=True)
class Name:
    """A piece of a text that names vehicles.

    Attributes:
        start: its first character.
        end: the one behind its last.
        vehicles: which, by their place among those that took part; none where it names somebody else.
    """

    start: int
    end: int
    vehicles: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class NamedCrash:
    """A text, and where it names its vehicles.

    Attributes:
        text: the summary.
        names: in any order.
        count: of vehicles that took part.
    """

    text: str
    names: tuple[Name, ...]
    count: int

    def turned(self, quarters: int) -> "NamedCrash":
        """The same, told of a place whose compass is so many quarter turns further round, clockwise."""
        text, places = turn_text(self.text, [(each.start, each.end) for each in self.names], quarters)
        names = [Name(*place, each.vehicles) for place, each in zip(places, self.names, strict=True)]
        return NamedCrash(text, tuple(names), self.count)


@dataclass(frozen=True, slots=True)
class MarkedText:
    """What the network is given.

    Attributes:
        pieces: (T,) int64, places in the vocabulary; the first begins the text, the last ends it.
        marks: (T,) int64, NOBODY, a vehicle's seat from 1, or SOMEBODY_ELSE.
        shares: (V, T) float32, how much a piece counts for what is said of a vehicle; where a text nowhere names it,
            the beginning does.
    """

    pieces: NDArray[np.int64]
    marks: NDArray[np.int64]
    shares: NDArray[np.float32]


def named_crash(summary: str, said: SummaryClaims) -> NamedCrash:
    """A summary and where it names the vehicles that took part, by what the rules have made out of it."""
    seats = {place: seat for seat, place in enumerate(said.kept)}
    names = [
        Name(each.span.start, each.span.end, tuple(seats[place] for place in each.vehicles if place in seats))
        for row in said.text.spoken.mentions
        for each in row
        if each.vehicles
    ]
    return NamedCrash(summary, tuple(names), len(said.kept))


def mark_text(crash: NamedCrash, pieces: WordPieces, seats: Sequence[int] | None = None) -> MarkedText:
    """Take a text apart and mark its names.

    Args:
        crash: the text.
        pieces: takes it apart.
        seats: of the vehicles, each from 0 below SEATS; in their order if not given.

    Raises:
        ValueError: there are more vehicles than seats.
    """
    if crash.count > SEATS:
        raise ValueError(f"{crash.count} vehicles: at most {SEATS} can be told apart")
    seats = range(crash.count) if seats is None else seats
    found, places = pieces.split(crash.text)
    whole = [pieces.begin, *found, pieces.end]
    marks = np.zeros(len(whole), np.int64)
    shares = np.zeros((crash.count, len(whole)), np.float32)
    for at, (start, end) in enumerate(places, start=1):
        for name in crash.names:
            if start < name.end and end > name.start:
                _mark(name, at, seats, marks, shares)
    shares[shares.sum(axis=1) == 0, 0] = 1.0
    return MarkedText(np.array(whole, np.int64), marks, shares)


def _mark(name: Name, at: int, seats: Sequence[int], marks: NDArray[np.int64], shares: NDArray[np.float32]) -> None:
    if len(name.vehicles) == 1:
        marks[at] = 1 + seats[name.vehicles[0]]
    elif not name.vehicles:
        marks[at] = SOMEBODY_ELSE
    for vehicle in name.vehicles:
        shares[vehicle, at] = max(shares[vehicle, at], 1.0 if len(name.vehicles) == 1 else _SHARED)
