"""Turns of phrase: a sentence as plain words with its numbers in figures, and patterns looked for in it.

What no grammar of lanes or limits foresees, people still say in few ways: "two up and two down", "they let you go 55".
Such turns are patterns of table ``phrases.yaml``.
"""

import functools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from roadmend.safe.claims import Span
from roadmend.safe.reading.lexicon import read_table
from roadmend.safe.reading.tokens import Item, Sentence, Words


@dataclass(frozen=True, slots=True)
class Wording:
    """A sentence in plain words.

    Attributes:
        text: its words in lower case, one space between them; numbers in figures.
        places: of each word's first letter in the text.
        items: the words.
    """

    text: str
    places: tuple[int, ...]
    items: Words

    def item(self, letter: int) -> int:
        """The place of the word to which a letter of the text belongs."""
        return max((at for at, place in enumerate(self.places) if place <= letter), default=0)

    def span(self, match: re.Match[str]) -> Span:
        """Where in the summary a match stands."""
        return self.items.span(self.item(match.start()), self.item(max(match.start(), match.end() - 1)))


def wording(sentence: Sentence) -> Wording:
    """A sentence in plain words."""
    words = [_plain(item) for item in sentence.items]
    for place, item in enumerate(sentence.items[:-2]):
        lane, after = sentence.items[place + 1 : place + 3]
        if item.low == "a" and lane.is_a("lane") and (after.is_a("each") or after.low == "for"):
            words[place] = "1"  # "a lane each way", "a lane for us"
    places, at = [], 0
    for word in words:
        places.append(at)
        at += len(word) + 1
    return Wording(" ".join(words), tuple(places), sentence.items)


def number_of(item: Item) -> Any:
    """The number that a word says: "three", and "all three", which is a word of its own."""
    return 3 if item.low == "all three" else item.get("number")


def _plain(item: Item) -> str:
    number = number_of(item)
    if item.is_a("mph"):
        return str(item.get("mph"))
    if item.low in {"ln", "lns"}:
        return "lanes" if item.low == "lns" else "lane"
    if number is None or item.low[:1].isdigit():
        return item.low
    return f"all {number:g}" if item.low.startswith("all ") else f"{number:g}"


@functools.cache
def patterns(name: str) -> tuple[re.Pattern[str], ...]:
    """The patterns of one kind; ``N`` in them is a number, ``W`` up to three words."""
    rows = read_table("phrases")[name]
    return tuple(
        re.compile(row.replace("W", r"(?:[^\W\d][^\W\d'/-]* ){0,3}").replace("N", r"\b(\d+)\b")) for row in rows
    )


def found(name: str, text: Wording) -> Iterator[re.Match[str]]:
    """The matches of all patterns of one kind."""
    for pattern in patterns(name):
        yield from pattern.finditer(text.text)
