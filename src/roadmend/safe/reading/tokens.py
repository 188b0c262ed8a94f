"""A text cut into sentences and words, each with its place, and the words read by the tables."""

import functools
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from roadmend.safe.claims import Span
from roadmend.safe.reading.english import is_english, is_in_dictionary
from roadmend.safe.reading.lexicon import (
    LONGEST,
    Senses,
    VerbSense,
    mend,
    names,
    senses,
    shorthand,
    squeeze,
    table_words,
    verb_heads,
    word_set,
)

_TOKEN = re.compile(
    r"\d+(?:st|nd|rd|th)\b|\d{1,3}(?:,\d{3})+(?!\d)|\d+(?:\.\d+)?|[^\W\d_]+(?:'(?!s\b)[^\W\d_]+)?|'s\b|[^\w\s]",
    re.IGNORECASE,
)
_STREET = re.compile(r"(?:[A-Z][a-z]+ )?(?:Rd|St|Ave|Blvd|Ln|Hwy|Street|Avenue|Road)\b")
# A short first line without a full stop over a longer one is a title; the match is the break after it.
_TITLE = re.compile(r"(?=[^\n.!?:;,]{10,65}\n[A-Z][^\n]{80})[^\n]*(?P<end>\n)")
_LETTERS = frozenset("NSEW")
_NAMED_LANES = frozenset({"Lane", "Ln"})  # of "Mill Lane", which is a road
_CUT = 4  # letters from which a word may have lost the last of "-ing"
_JOINED = 5  # letters of a phrase that may be told without a hyphen or a slash in it: not "a t" for "at"
_PLAIN = dict.fromkeys(map(ord, '\u201c\u201d"\u00ab\u00bb*_'), " ") | {
    **dict.fromkeys(map(ord, "\u2019\u2018"), "'"),
    **dict.fromkeys(map(ord, "\u2013\u2014"), "-"),
}


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

    def get(self, kind: str) -> Any:
        """What it means as a word of this kind; None where it is none."""
        return self.kinds.get(kind)

    @property
    def verb(self) -> VerbSense | None:
        """The verb that it may be."""
        found: VerbSense | None = self.kinds.get("verb")
        return found

    @property
    def is_name(self) -> bool:
        """Whether it begins with a capital."""
        return self.text[:1].isupper()


NOTHING = Item("", "", Span(0, 0))


class Words(tuple[Item, ...]):
    """Some words in their order; what lies beyond them is :data:`NOTHING`."""

    __slots__ = ()

    def at(self, place: int) -> Item:
        """The word at a place."""
        return self[place] if 0 <= place < len(self) else NOTHING

    def cut(self, first: int, last: int | None = None) -> "Words":
        """Those from one place up to another, not included."""
        return Words(self[max(0, first) : None if last is None else max(0, last)])

    def has(self, *kinds: str) -> bool:
        """Whether one of them may be of one of these kinds."""
        return any(item.is_a(*kinds) for item in self)

    def says(self, words: Collection[str]) -> bool:
        """Whether one of them is one of these."""
        return any(item.low in words for item in self)

    def first(self, *kinds: str) -> Item | None:
        """The first that may be of one of these kinds."""
        return next((item for item in self if item.is_a(*kinds)), None)

    def span(self, first: int, last: int) -> Span:
        """From one of them to another, included."""
        return Span(self[first].span.start, self[last].span.end)


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
    items: Words
    span: Span


def read_sentences(summary: str) -> tuple[Sentence, ...]:
    """Cut a text into sentences, and read their words."""
    text = summary.translate(_PLAIN)  # keeps the places
    found: list[Sentence] = []
    start = 0
    title = _TITLE.match(text)
    breaks = [*([title] if title is not None else []), *re.finditer(r"\n\s*\n", text), None]
    for paragraph, match in enumerate(breaks):
        for tokens in _cut(text, start, _break(match) if match is not None else len(text)):
            span = Span(tokens[0].start, tokens[-1].end)
            found.append(Sentence(len(found), paragraph, Words(_items(tokens)), span))
        start = match.end() if match is not None else start
    return tuple(found)


def _break(match: re.Match[str]) -> int:
    """Where the text before a break ends."""
    return match.start("end") if "end" in match.re.groupindex else match.start()


def _cut(text: str, start: int, end: int) -> Iterator[list[Token]]:
    tokens: list[Token] = []
    for match in _TOKEN.finditer(text, start, end):
        word = match[0]
        around = text[match.start() - 1 : match.start()] + text[match.end() : match.end() + 1]
        if word == "-" and not any(letter.isspace() for letter in around):
            continue  # a hyphen within a word
        is_glued = bool(tokens) and text[tokens[-1].end : match.start()] in {"", "-", "."}
        if word in ".!?" and _ends(text, match.start(), tokens):
            if tokens:
                yield tokens
            tokens = []
        elif word != "." or not is_glued:
            low = _in_full(word, is_first=not tokens)
            tokens.append(Token(word, low, match.start(), match.end(), is_glued))
    if tokens:
        yield tokens


def _in_full(word: str, *, is_first: bool) -> str:
    """A word in small letters, as it is written in full and without a slip of the pen: "sittin" for "sitting"."""
    low = word.lower()
    is_model = word.istitle() and not is_first and low in names()  # a Renault Trafic
    full = low if is_model else shorthand().get(low, low)
    is_cut = full.endswith("in") and len(full) > _CUT and f"{full}g" in senses() and full not in senses()
    if is_cut or full in senses() or full in names() or full in table_words():
        return f"{full}g" if is_cut else full
    if not full.isalpha() or is_english(full):
        return full
    mended = mend(full, is_word=is_in_dictionary(full))
    may_be_name = word.istitle() and not is_first and mended is not None and mended not in names()
    return full if mended is None or (may_be_name and "thing" not in senses()[mended]) else mended


def _ends(text: str, place: int, tokens: Sequence[Token]) -> bool:
    """Whether a sentence ends at a full stop."""
    after = text[place + 1 : place + 2]
    if text[place] in "!?" or (after and not after.isspace() and after not in ")]'"):
        return text[place] in "!?"
    rest = text[place + 1 :].lstrip(" )]'\n")
    if rest[:1].islower() and not _is_careless(text):
        return False
    if (
        tokens
        and tokens[-1].low == "m"
        and re.match(r"[A-Z]\w+", rest)
        and rest.split()[0].lower() in word_set("weekdays")
    ):
        return False  # "at 3 p.m. Sunday"
    last = tokens[-1].low if tokens else ""
    is_short = last in word_set("abbreviations") or (len(last) == 1 and last.isalpha())
    if is_short and len(tokens) > 1 and len(last) == 1 and "thing" in senses().get(squeeze(tokens[-2].low), {}):
        return True  # "the offside of Vehicle A."
    goes_on = not rest[:1].isupper() or last not in word_set("ends_with_capital") or bool(_STREET.match(rest))
    return not is_short or not goes_on


@functools.lru_cache(maxsize=8)
def _is_careless(text: str) -> bool:
    """Whether sentences begin in lower case."""
    begins = re.findall(r"(?:^|[.!?]\s+)([^\W\d_])", text)
    return bool(sum(letter.islower() for letter in begins) * 4 > len(begins))


def _items(tokens: Sequence[Token]) -> Iterator[Item]:
    place = 0
    while place < len(tokens):
        length, kinds = _longest(tokens, place)
        taken = tokens[place : place + length]
        low, text = (" ".join(words) for words in zip(*((token.low, token.text) for token in taken), strict=True))
        yield Item(low, text, Span(taken[0].start, taken[-1].end), kinds)
        place += length


def _longest(tokens: Sequence[Token], place: int) -> tuple[int, Senses]:
    """How many words from here mean something together, and what."""
    for length in range(min(LONGEST, len(tokens) - place), 0, -1):
        taken = tokens[place : place + length]
        letters = [squeeze(token.low) for token in taken]
        key = "".join(letters) if letters[0] and letters[-1] and taken[-1].low != "'s" else ""
        if length == 2 and key in word_set("one_word"):
            continue  # "a head-on collision" is not ahead
        if length > 1 and len(key) < _JOINED and not all(token.is_glued for token in taken[1:]):
            continue
        if length > 1 and taken[-1].low == "s" and place + length < len(tokens) and tokens[place + length].low == "/":
            continue  # "pickup s/b": no pickups
        kinds = dict(senses().get(key, {}) or _loose_verb(taken))
        named = names().get(key, ()) if key and _may_be_name(taken) else ()
        if length == 1 and not named and not kinds and key.endswith("s") and len(key) > _JOINED:
            named = tuple(
                each for each in names().get(key[:-1], ()) if taken[0].text[:1].isupper() or not each.is_everyday
            )  # "the altimas door"
        if named:
            kinds["name"] = named
        if length > 1 and "ends" in kinds:
            kinds |= {"verb": verb} if (verb := senses().get(squeeze(taken[0].low), {}).get("verb")) else {}
        if (
            length == 1
            and "lane" in kinds
            and taken[0].text in _NAMED_LANES
            and place
            and tokens[place - 1].text.istitle()
        ):
            kinds = (
                {"road": "plain"}
                if not {"determiner", "preposition"} & senses().get(tokens[place - 1].low, {}).keys()
                else kinds
            )
        if length == 1 and "driveway" in kinds and taken[0].text.istitle() and place:
            del kinds["driveway"]  # "Church Street", not a church
        if length == 1 and key.isdigit():
            kinds["number"] = int(key)  # an Audi 100, and a hundred
        following = tokens[place + 1] if place + 1 < len(tokens) else None
        is_glued = following is not None and following.is_glued and following.text.isdigit()  # the road "N2"
        is_glued |= place > 0 and tokens[place - 1].text == "/"  # "F/E"
        if length == 1 and taken[0].text in _LETTERS and not is_glued:
            kinds["compass"] = taken[0].text
        if key and kinds:
            return length, kinds
    return 1, _single(tokens[place])


def _single(token: Token) -> Senses:
    """What a word means that no table has: a number."""
    figures = token.low.replace(",", "")
    if figures.replace(".", "").isdigit():
        number = float(figures)
        return {"number": int(number) if number.is_integer() else number}
    return {}


def _loose_verb(taken: Sequence[Token]) -> Senses:
    """A verb whose particle is parted from it: "ran straight into"."""
    if len(taken) <= 2 or taken[-1].low not in word_set("particles") or taken[0].low not in verb_heads():
        return {}
    kept = [
        token.low for token in taken[1:-1] if token.low != "it" and "adverb" not in senses().get(squeeze(token.low), {})
    ]
    kinds = senses().get("".join(map(squeeze, [taken[0].low, *kept, taken[-1].low])), {})
    return kinds if "verb" in kinds else {}


def _may_be_name(taken: Sequence[Token]) -> bool:
    """Not a number alone, nor pieces far from a name: "the 3 vehicles"."""
    letters = "".join(token.low for token in taken)
    return not (letters in {"is", "a", "in", "up", "one"} or (letters.isdigit() and len(letters) <= 2))
