"""Sentences as trees: the arcs that a trained parser of English finds between the words of a sentence.

It was trained on edited prose, so each sentence is handed to it in full words: what hasty writers cut short is written
out, capitals throughout are made small, and each vehicle is an article and a name, without what is told of it in passing.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from roadmend.safe.reading.english import pipeline
from roadmend.safe.reading.groups import NounGroup
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.tokens import Item, Sentence, Words

_WAYS = {"N": "northbound", "S": "southbound", "E": "eastbound", "W": "westbound"}
_PRONOUNS = {MentionKind.SELF, MentionKind.ONE, MentionKind.IT, MentionKind.POSSESSIVE, MentionKind.BOTH}
_OWNER = {"my": "me", "our": "us", "its": "it", "his": "him", "her": "her", "their": "them", "whose": "which"}
_SPLICES = frozenset({"into", "vs", "to", "behind", "="})  # that make a statement of two names
_HITS = {"ing": "hitting", "s": "hits"}
_BENDS = {"bend": "curve", "bends": "curves"}
_ASIDE = 9  # words of a bracket at most
_SHORT = 4  # letters of a word that may be one cut short
_PLAIN = {
    "thing": "vehicle",
    "junction": "intersection",
    "lane": "lane",
    "mph": "mph",
    "preposition": "",
    "road": "road",
}
_SPELLED = {"w": "with", "&": "and", "@": "at", "v": "versus", "=": "is", "+": "and", "im": "i'm"}


@dataclass(frozen=True, slots=True)
class Arc:
    """What ties a word to the one that governs it.

    Attributes:
        head: place of that word in the sentence; its own where nothing governs it.
        relation: of the two, by the names of the parser: "nsubj", "dobj", "relcl".
        tag: the word's part of speech, by the names of Universal Dependencies: "VERB", "PROPN".
        lemma: its base form.
    """

    head: int
    relation: str
    tag: str
    lemma: str


class Tree(tuple[Arc, ...]):
    """The arcs of a sentence, one for each of its words."""

    __slots__ = ()

    def children(self, place: int, *relations: str) -> Iterator[int]:
        """Words that a word governs, by one of some relations; all where none is given."""
        for at, arc in enumerate(self):
            if arc.head == place and at != place and (not relations or arc.relation in relations):
                yield at

    def has(self, place: int, *relations: str) -> bool:
        """Whether a word governs another one, by one of some relations."""
        return next(self.children(place, *relations), None) is not None

    def chain(self, place: int) -> Iterator[int]:
        """The words above a word, from its own head up to the root."""
        seen = {place}
        while (head := self[place].head) not in seen:
            yield head
            seen.add(head)
            place = head


def parse(sentences: Sequence[Sentence], groups: Sequence[Sequence[NounGroup]]) -> list[Tree]:
    """The trees of some sentences.

    Args:
        sentences: of a text.
        groups: of nouns that name vehicles in each of them.
    """
    model = pipeline()
    from spacy.tokens import Doc  # noqa: PLC0415 - as the model, and after it: two imports at once fail

    rows = [list(_words(sentence.items, row)) for sentence, row in zip(sentences, groups, strict=True)]
    docs = (
        Doc(model.vocab, words=[word for word, _ in row], sent_starts=_starts(row, each.items, mine))
        for row, each, mine in zip(rows, sentences, groups, strict=True)
    )
    trees = model.pipe(docs, batch_size=64)
    return [
        _tree(doc, [at for _, at in row], len(sentence.items))
        for doc, row, sentence in zip(trees, rows, sentences, strict=True)
    ]


def _starts(row: Sequence[tuple[str, int]], items: Words, groups: Sequence[NounGroup]) -> list[bool | int | None]:
    """Where a statement begins that only a comma parts from the one before: "V1 turned, V2 hit it"."""
    begins = set()
    for one, group in itertools.pairwise(groups):
        mark, mention = items.at(group.first - 1).low, group.mention
        named = mention is not None and (mention.number is not None or mention.description is not None)
        led = any(
            items[at].is_a("verb", "auxiliary", "bound") or items[at].low in _SPLICES
            for at in range(one.last + 1, group.first)
        )
        goes_on = any(
            items[at].is_a("verb", "auxiliary", "bound") or items[at].low in _SPLICES
            for at in range(group.last + 1, min(group.last + 5, len(items)))
        )
        if mark in {",", ";", ":", "."} and named and mention is not None and mention.twin is None and led and goes_on:
            begins.add(next((place for _, place in row if group.first <= place <= group.top), group.top))
    return [
        True if at == 0 or (place in begins and place != row[at - 1][1]) else None for at, (_, place) in enumerate(row)
    ]


def _tree(doc: Any, places: Sequence[int], count: int) -> Tree:
    """Arcs between items: an item of several words hangs where the one of them hangs that the others hang on."""
    words: dict[int, list[int]] = {}
    for at, place in enumerate(places):
        words.setdefault(place, []).append(at)
    arcs: list[Arc] = []
    for place in range(count):
        mine = words.get(place)
        if mine is None:  # joined to the word before it
            near = min(words, key=lambda each: (abs(each - place), each))
            arcs.append(Arc(near, "fixed", "X", ""))
            continue
        tops = [at for at in mine if places[doc[at].head.i] != place or doc[at].head.i == at]
        top = doc[next((at for at in tops if doc[at].pos_ in {"VERB", "AUX"}), tops[0] if tops else mine[0])]
        arcs.append(Arc(places[top.head.i], top.dep_, top.pos_, top.lemma_.lower()))
    return Tree(arcs)


def _words(items: Words, groups: Sequence[NounGroup]) -> list[tuple[str, int]]:
    """The words for the parser, each with the place of the item that it is of: every vehicle in as few as will do."""
    shouts = sum(item.text.isupper() for item in items if len(item.text) > 1) * 2 > len(items)
    starts = {group.first: group for group in groups}
    found: list[tuple[str, int]] = []
    place = 0
    while place < len(items):
        group = starts.get(place)
        if group is not None and group.mention is not None and _is_aside(items, group.mention):
            if found and found[-1][0] in {",", "("}:
                found.pop()
            place = _after_twin(items, group.mention)
        elif group is not None and group.mention is not None:
            found += _called(items, group.mention, group.top, shouts=shouts)
            if group.is_place and items[group.last].low == "'s":
                found.append(("'s", group.last))
            place = group.last + 1
        elif items[place].low == "(" and (end := _bracket(items, place, groups)):
            place = end + 1
        elif items[place].low == "left" and not _is_departure(items, place):
            found.append(("right", place))  # which is as much a hand, and no verb
            place += 1
        else:
            found += [(word, place) for word in _written(items[place], shouts=shouts)]
            place += 1
    return found or [(".", 0)]


def _bracket(items: Words, place: int, groups: Sequence[NounGroup]) -> int:
    """Where a bracket ends that says nothing of vehicles; 0 where there is none."""
    end = next((at for at in range(place + 1, min(place + _ASIDE, len(items))) if items[at].low == ")"), 0)
    inside = range(place, end + 1)
    is_told = any(group.first in inside for group in groups) or any(items[at].verb is not None for at in inside)
    return 0 if is_told else end


def _is_aside(items: Words, mention: Mention) -> bool:
    """Whether a mention is a second name between commas or in brackets, or stands right behind the first."""
    if mention.twin is None or mention.twin.last >= mention.first:
        return False
    opened, closed = items.at(mention.first - 1).low, items.at(mention.last + 1).low
    return mention.first == mention.twin.last + 1 or opened == "(" or (opened, closed) in {(",", ","), (",", "")}


def _after_twin(items: Words, mention: Mention) -> int:
    """The place after a second name of the same vehicle and the comma or bracket that closes it."""
    if items.at(mention.first - 1).low == "(":
        closes = range(mention.last + 1, min(mention.last + _ASIDE, len(items)))
        return next((at + 1 for at in closes if items[at].low == ")"), mention.last + 1)
    closed = items.at(mention.last + 1).low in {",", ")"} and items.at(mention.first - 1).low in {",", "("}
    return mention.last + 1 + closed


def _is_departure(items: Words, place: int) -> bool:
    """Whether "left" is the past of "leave" and no hand: "V1 left the road"."""
    before, after = items.at(place - 1), items.at(place + 1)
    goes = after.is_a("determiner", "road", "shoulder", "driveway") or after.get("pronoun") in {"its", "own"}
    hand = before.is_a("determiner") or (before.verb is not None and before.verb.kind in {"turn", "do", "travel"})
    return goes and not hand and not after.is_a("hand", "lane")


def _called(items: Words, mention: Mention, top: int, *, shouts: bool) -> Iterator[tuple[str, int]]:
    """What the parser reads of a vehicle, its driver or a part of it: a number, a pronoun, or an article and one name."""
    inside = range(mention.first, mention.last + 1)
    named = [at for at in inside if items[at].is_a("name", "body")]
    first, head = items[mention.first], items[named[-1]] if named else items[mention.last]
    if mention.number is not None and not named:
        yield f"V{mention.number}", top
        return
    if mention.kind in _PRONOUNS and mention.first == mention.last:
        word = first.low if top == mention.last else _OWNER.get(first.low, first.low)
        yield ("I" if word == "i" else word), top
        return
    if mention.first < mention.last and first.is_a("determiner", "pronoun"):
        yield first.low, mention.first
    if mention.is_person and mention.description is not None:
        yield "driver", top
    elif head.is_a("name") and not head.is_a("body"):
        yield "".join(head.text.split()).title(), top
    else:
        yield from ((word, top) for word in _written(head, shouts=shouts))


def _written(item: Item, *, shouts: bool) -> Iterator[str]:
    """The words of an item as edited prose has them."""
    if item.is_a("bound") and " to " not in item.low:
        yield _WAYS[item.get("bound")]
        return
    if item.is_a("head_on", "broadside") and item.verb is None:
        yield "hard"  # the parser takes "head" of "head on" for a noun
        return
    if item.verb is not None and item.verb.kind.startswith("strike") and (item.verb.form != "base" or " " in item.low):
        yield _HITS.get(item.verb.form, "hit")  # which edited prose has more often than "contacted" and "T-boned"
        return
    if item.is_a("curve") and item.low in _BENDS:
        yield _BENDS[item.low]
        return
    words, texts = item.low.split(), item.text.split()
    if item.is_a("name") and words and words[-1].isdigit():  # "F 150"
        texts, words = ["".join(texts)], ["".join(words)]
    for word, text in zip(words, texts, strict=True):
        yield _in_full(item, word, text if not shouts else text.lower() if not item.is_a("name") else text.title())


def _in_full(item: Item, word: str, text: str) -> str:
    if word in _SPELLED:
        return _SPELLED[word]
    if item.is_a("person") and len(word) <= 3 and item.get("person") == "driver":
        return "driver"
    if item.is_a("hand") and len(word) <= 2:
        return "right"  # as much a hand as "left", and no verb
    if len(word) <= _SHORT and not item.is_a("verb"):
        full = next((full for kind, full in _PLAIN.items() if full and item.is_a(kind)), "")
        if full and word not in {"road", "car", "exit"} and not text.istitle():
            return full
    if text.lower() != word:  # written out by the table of shorthand
        return word.title() if text.istitle() else word
    return "I" if word == "i" else text
