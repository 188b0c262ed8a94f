"""Told crashes with their keys, as the trained reader learns from them."""

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.safe.dsl import RoadType
from roadmend.safe.trained.marked_text import NOBODY, MarkedText, Name, NamedCrash, mark_text
from roadmend.safe.trained.outputs import HEADINGS, OF_PAIR, OF_PIECE, OF_TEXT, OF_VEHICLE, SEATS, STEMS, ReaderQuestion
from roadmend.safe.trained.word_pieces import WordPieces
from roadmend.training.text_reading import UNASKED, Questions, TextSample

_FORGOTTEN = 0.1  # share of names that a lesson leaves unmarked, since rules do not find all
_UNMARKED = 0.2  # share of lessons in which nobody is marked, and who is named is asked

Ints = NDArray[np.int64]


def questions_of_training() -> Questions:
    """What lessons ask, as the network is fitted to it."""
    groups = ([(len(each.values), each.weight) for each in group] for group in (OF_VEHICLE, OF_PAIR, OF_TEXT, OF_PIECE))
    return Questions(*groups)


@dataclass(frozen=True, slots=True)
class CrashLesson:
    """A told crash, and the answers to what is asked of it.

    Attributes:
        crash: the text and its names.
        vehicles: (V, questions) of each vehicle.
        pairs: (V, V, questions) of each two.
        text: (questions,).
    """

    crash: NamedCrash
    vehicles: Ints
    pairs: Ints
    text: Ints

    def draw(self, pieces: WordPieces, longest: int, generator: random.Random) -> TextSample:
        """The lesson as it is taught this time: turned on the compass, seats given anew, some names forgotten or all unmarked.

        Args:
            pieces: take the text apart.
            longest: text that the encoder can read, in pieces; the rest is cut off.
            generator: draws.
        """
        quarters = generator.randrange(4)
        crash = self.crash.turned(quarters)
        if generator.random() < _UNMARKED:
            marked = mark_text(crash, pieces)
            parties = _parties(marked)
            marks = np.full_like(marked.marks, NOBODY)
        else:
            names = tuple(name for name in crash.names if generator.random() >= _FORGOTTEN)
            seats = generator.sample(range(SEATS), crash.count)
            marked = mark_text(replace(crash, names=names), pieces, seats)
            parties = np.full_like(marked.marks, UNASKED)
            marks = marked.marks
        return TextSample(
            marked.pieces[:longest],
            marks[:longest],
            _somewhere(marked.shares[:, :longest]),
            _turned(self.vehicles, OF_VEHICLE, "heading", quarters),
            self.pairs,
            _turned(self.text, OF_TEXT, "stem", quarters),
            parties[:longest, None],
        )


def _parties(marked: MarkedText) -> Ints:
    """Whom each piece names, by the order in which they are first named; UNASKED where several at once."""
    found = np.zeros(len(marked.marks), np.int64)
    order: dict[int, int] = {}
    for at, mark in enumerate(marked.marks.tolist()):
        if 0 < mark <= SEATS:
            found[at] = order.setdefault(mark, len(order) + 1)
        elif mark == NOBODY and at and marked.shares[:, at].any():
            found[at] = UNASKED
    return found


def _somewhere(shares: NDArray[np.float32]) -> NDArray[np.float32]:
    """Who is named only beyond the longest text is looked for at its beginning."""
    shares[shares.sum(axis=1) == 0, 0] = 1.0
    return shares


def _turned(answers: Ints, questions: Sequence[ReaderQuestion], name: str, quarters: int) -> Ints:
    at = next(place for place, question in enumerate(questions) if question.name == name)
    found = answers.copy()
    own = found[..., at]
    found[..., at] = np.where(own == UNASKED, UNASKED, (own + quarters) % len(HEADINGS))
    return found


def lesson_of(crash: NamedCrash, key: Mapping[str, Any]) -> CrashLesson:
    """A lesson from a text and its key, the fields of the scenario language as JSON has them.

    Raises:
        ValueError: the key has another number of vehicles than the text.
    """
    vehicles = key["vehicles"]
    if len(vehicles) != crash.count:
        raise ValueError(f"{crash.count} vehicles in the text, {len(vehicles)} in its key")
    own = [[_place(each.get(asked.field), asked) for asked in OF_VEHICLE] for each in vehicles]
    whole = {**key, **{f"env.{name}": value for name, value in (key.get("env") or {}).items()}}
    if key.get("road_type") != RoadType.T_INTERSECTION:
        whole["stem_direction"] = None
    return CrashLesson(
        crash,
        np.array(own, np.int64).reshape(len(own), len(OF_VEHICLE)),
        _pairs(own, key.get("collisions") or ()),
        np.array([_place(whole.get(asked.field), asked) for asked in OF_TEXT], np.int64),
    )


def _place(value: Any, asked: ReaderQuestion) -> int:
    """Which of a question's answers a value is; UNASKED where none."""
    value = round(value) if isinstance(value, float) else value  # a limit, in whole miles
    return asked.values.index(value) if value in asked.values else UNASKED


def _pairs(vehicles: Sequence[Sequence[int]], collisions: Sequence[Mapping[str, Any]]) -> Ints:
    """How the second of two vehicles lies to the first, and where the first struck it."""
    count = len(vehicles)
    found = np.full((count, count, len(OF_PAIR)), UNASKED, np.int64)
    headings = [row[0] for row in vehicles]
    for first in range(count):
        for second in range(count):
            if first == second:
                continue
            if UNASKED not in (headings[first], headings[second]):
                found[first, second, 0] = (headings[second] - headings[first]) % len(HEADINGS)
            found[first, second, 1:] = 0 if collisions else UNASKED  # nobody was struck, as far as is told
    for each in collisions:
        first, second = (each.get("striking") or 0) - 1, (each.get("struck") or 0) - 1
        if first != second and 0 <= first < count and 0 <= second < count:
            sides = (each.get("struck_side"), each.get("striking_side"))
            for at, (side, asked) in enumerate(zip(sides, OF_PAIR[1:], strict=True), start=1):
                found[first, second, at] = _place(str(side).capitalize(), asked) if side else UNASKED
    return found


def names_by_words(text: str, called: Sequence[Sequence[str]]) -> NamedCrash:
    """A text whose vehicles are named by given words, wherever these stand in it as whole words; longer ones first."""
    words = sorted(
        ((word, at) for at, row in enumerate(called) for word in row if word), key=lambda each: -len(each[0])
    )
    taken, names = np.zeros(len(text), bool), list[Name]()
    low = text.lower()
    for word, vehicle in words:
        start = low.find(word.lower())
        while start >= 0:
            end = start + len(word)
            inside = (start and low[start - 1].isalnum() and word[0].isalnum()) or (
                end < len(low) and low[end].isalnum() and word[-1].isalnum()
            )
            if not inside and not taken[start:end].any():
                taken[start:end] = True
                names.append(Name(start, end, (vehicle,)))
            start = low.find(word.lower(), end)
    return NamedCrash(text, tuple(names), len(called))


assert OF_VEHICLE[0].name == "heading"
assert len(STEMS) == len(HEADINGS)
