"""A text cut into sentences and words, each with its place, and the words read by the tables."""

import functools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from roadmend.safe.claims import Span
from roadmend.safe.reading.lexicon import (
    LONGEST,
    NameSense,
    Senses,
    VerbSense,
    mend,
    names,
    senses,
    squeeze,
    verb_heads,
)

_TOKEN = re.compile(
    r"\d+(?:st|nd|rd|th)\b|\d{1,3}(?:,\d{3})+(?!\d)|\d+(?:\.\d+)?|[^\W\d_]+(?:'(?!s\b)[^\W\d_]+)?|'s\b|[^\w\s]",
    re.IGNORECASE,
)
_ABBREVIATIONS = frozenset(
    [
        "vs",
        "mr",
        "mrs",
        "ms",
        "dr",
        "st",
        "ave",
        "rd",
        "blvd",
        "hwy",
        "no",
        "veh",
        "approx",
        "ft",
        "mi",
        "jr",
        "sr",
        "sgt",
        "lt",
        "capt",
        "cpl",
        "dept",
        "ln",
        "dr",
        "pkwy",
        "u.s",
        "a.m",
        "p.m",
        "m.p.h",
        "i.e",
        "e.g",
        "n",
        "s",
        "e",
        "w",
        "pass",
        "op",
        "opr",
        "mph",
        "kmh",
    ]
)
_JOINED = 5  # letters of a phrase that may be told without a hyphen or a slash in it: not "a t" for "at"
_PARTICLES = frozenset({"into", "with", "off", "onto", "against", "through"})
_QUOTES = dict.fromkeys(map(ord, '“”"«»*_'), " ") | {ord("’"): "'", ord("‘"): "'", ord("–"): "-", ord("—"): "-"}  # noqa: RUF001


@dataclass(frozen=True, slots=True)
class Token:
    """A word, a figure or a mark."""

    text: str
    low: str
    start: int
    end: int
    is_glued: bool  # whether no space is before it


@dataclass(slots=True)
class Item:
    """One or more words that mean something together.

    Attributes:
        low: the words in lower case.
        text: as written.
        span: in the summary.
        kinds: all that they may mean, by kind.
    """

    low: str
    text: str
    span: Span
    kinds: Senses = field(default_factory=dict)

    def is_a(self, *kinds: str) -> bool:
        """Whether it may mean one of these."""
        return any(kind in self.kinds for kind in kinds)

    @property
    def verb(self) -> VerbSense | None:
        """The verb that it may be."""
        found: VerbSense | None = self.kinds.get("verb")
        return found


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence.

    Attributes:
        index: from 0.
        paragraph: its number, from 0.
        items: its words.
        span: in the summary.
    """

    index: int
    paragraph: int
    items: tuple[Item, ...]
    span: Span


def read_sentences(summary: str) -> tuple[Sentence, ...]:
    """Cut a text into sentences, and read their words."""
    text = summary.translate(_QUOTES)  # keeps the places
    found: list[Sentence] = []
    for paragraph, (start, end) in enumerate(_paragraphs(text)):
        for tokens in _cut(text, start, end):
            items = tuple(_items(tokens))
            if items:
                span = Span(tokens[0].start, tokens[-1].end)
                found.append(Sentence(len(found), paragraph, items, span))
    return tuple(found)


def _paragraphs(text: str) -> Iterator[tuple[int, int]]:
    start = 0
    for match in re.finditer(r"\n\s*\n", text):
        yield start, match.start()
        start = match.end()
    yield start, len(text)


def _cut(text: str, start: int, end: int) -> Iterator[list[Token]]:
    tokens: list[Token] = []
    for match in _TOKEN.finditer(text, start, end):
        word = match[0]
        if (
            word == "-"
            and not text[match.end() : match.end() + 1].isspace()
            and not text[match.start() - 1 : match.start()].isspace()
        ):
            continue  # a hyphen within a word
        is_glued = bool(tokens) and (tokens[-1].end == match.start() or text[tokens[-1].end : match.start()] == "-")
        if word in ".!?" and _ends(text, match.start(), tokens):
            if tokens:
                yield tokens
            tokens = []
        elif word != "." or not is_glued:
            tokens.append(Token(word, word.lower(), match.start(), match.end(), is_glued))
    if tokens:
        yield tokens


def _ends(text: str, place: int, tokens: Sequence[Token]) -> bool:
    after = text[place + 1 : place + 3]
    if text[place] in "!?":
        return True
    if after[:1] and not after[:1].isspace() and after[:1] not in ")]'":
        return False
    is_short = bool(tokens) and (
        tokens[-1].low in _ABBREVIATIONS or (len(tokens[-1].low) == 1 and tokens[-1].low.isalpha())
    )
    rest = text[place + 1 :].lstrip(" )]'\n")
    if rest[:1].islower() and not _is_careless(text):
        return False
    return not is_short or (
        rest[:1].isupper()
        and tokens[-1].low in {"mph", "kmh", "m", "rd", "hwy", "st", "ave", "blvd", "ln", "w", "e", "n", "s"}
        and not _continues_name(rest)
    )


@functools.lru_cache(maxsize=8)
def _is_careless(text: str) -> bool:
    """Whether sentences begin in lower case."""
    begins = re.findall(r"(?:^|[.!?]\s+)([^\W\d_])", text)
    return bool(sum(letter.islower() for letter in begins) * 4 > len(begins))


def _continues_name(rest: str) -> bool:
    return bool(re.match(r"(?:Rd|St|Ave|Blvd|Ln|Hwy|Street|Avenue|Road)\b", rest)) or bool(
        re.match(r"[A-Z][a-z]+ (?:Rd|St|Ave|Street|Avenue|Road|Blvd)\b", rest)
    )


def _items(tokens: Sequence[Token]) -> Iterator[Item]:
    place = 0
    while place < len(tokens):
        length, kinds = _longest(tokens, place)
        taken = tokens[place : place + length]
        low = " ".join(token.low for token in taken)
        yield Item(low, " ".join(token.text for token in taken), Span(taken[0].start, taken[-1].end), kinds)
        place += length


def _longest(tokens: Sequence[Token], place: int) -> tuple[int, Senses]:
    for length in range(min(LONGEST, len(tokens) - place), 0, -1):
        taken = tokens[place : place + length]
        letters = [squeeze(token.low) for token in taken]
        key = "".join(letters) if letters[0] and letters[-1] and taken[-1].low != "'s" else ""
        if length > 1 and len(key) < _JOINED and not all(token.is_glued for token in taken[1:]):
            continue
        kinds = dict(senses().get(key, {}))
        if length > 2 and not kinds and taken[-1].low in _PARTICLES and _starts_verb(taken[0]):
            kept = [taken[0], *(token for token in taken[1:] if "adverb" not in senses().get(squeeze(token.low), {}))]
            kinds = dict(senses().get("".join(squeeze(token.low) for token in kept), {})) if len(kept) > 1 else {}
            kinds = kinds if "verb" in kinds and taken[-1] is kept[-1] else {}
        named = names().get(key, ()) if key and _may_be_name(taken) else ()
        if named:
            kinds["name"] = named
        if length == 1 and key.isdigit():
            kinds["number"] = int(key)  # an Audi 100, and a hundred
        if key and kinds:
            return length, kinds
    token = tokens[place]
    if token.low.replace(",", "").replace(".", "").isdigit():
        number = float(token.low.replace(",", ""))
        return 1, {"number": int(number) if number.is_integer() else number}
    mended = mend(token.low) if place == 0 or token.low == token.text or token.text.isupper() else None
    if mended is not None:
        kinds = dict(senses().get(mended, {}))
        if mended in names():
            kinds["name"] = names()[mended]
        return 1, kinds
    return 1, {}


def _starts_verb(token: Token) -> bool:
    return token.low in verb_heads()


def _may_be_name(taken: Sequence[Token]) -> bool:
    """Not a number alone, nor pieces far from a name: "the 3 vehicles"."""
    letters = "".join(token.low for token in taken)
    return not (
        letters in {"is", "a", "in", "up", "one"} or (len(taken) == 1 and taken[0].low.isdigit() and len(letters) < 3)
    )


def name_senses(item: Item) -> tuple[NameSense, ...]:
    """The makes and models that it may be."""
    found: tuple[NameSense, ...] = item.kinds.get("name", ())
    return found
