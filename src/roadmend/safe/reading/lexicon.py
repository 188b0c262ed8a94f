"""The tables of this folder, made fit for look-up: words and phrases, verbs in all their forms, makes and models.

A phrase is found by its letters alone, so that "rear-ended", "rear ended" and "rearended" are one, and "F-150" is
"F150". What is one letter away from a single long word of the tables counts as that word: people mistype.
"""

import functools
import importlib.resources
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from roadmend.core.yaml_file import parse_yaml
from roadmend.safe.dsl import DslModel

Senses = Mapping[str, Any]  # kind of word -> what it means; a word may be of several kinds

LONGEST = 7  # words in a phrase
_FUZZY_FROM = 4  # letters
_WRONG_LETTER, _NO_SLIP = 2, 9  # kinds of slips
_VOWELS = "aeiou"
_PREFIXES = frozenset({"rear", "t", "side", "u", "broad", "tail", "lane", "double", "re"})
_SHORT = 4  # letters of a verb that doubles its last one: "stop", "skid"
_CLASSES = {
    "sedan": DslModel.SEDAN,
    "suv": DslModel.SUV,
    "minivan": DslModel.MINIVAN,
    "pickup": DslModel.PICKUP,
    "truck": DslModel.SEMI_TRUCK,
}


@dataclass(frozen=True, slots=True)
class VerbSense:
    """A form of a verb.

    Attributes:
        kind: what happens ("strike", "turn").
        lemma: its first word.
        form: "base", "s", "past", "participle", "both" (past or participle), "ing".
    """

    kind: str
    lemma: str
    form: str


@dataclass(frozen=True, slots=True)
class NameSense:
    """A make, a model, or both.

    Attributes:
        make: as the tables write it.
        model: None for a make alone.
        body: its class; None where the make builds several.
        is_everyday: whether the word means something else in most texts.
    """

    make: str
    model: str | None
    body: DslModel | None
    is_everyday: bool


@dataclass(frozen=True, slots=True)
class BodySense:
    """A word for a kind of vehicle; the body is None where the scenario language has no class for it."""

    body: DslModel | None
    confidence: float


def squeeze(text: str) -> str:
    """The letters and figures by which a phrase is found."""
    return re.sub(r"[ \-'.]", "", text.lower())


@functools.cache
def read_table(name: str) -> Any:
    """The content of one table."""
    file = importlib.resources.files(__package__).joinpath("tables", f"{name}.yaml")
    return parse_yaml(file.read_text(encoding="utf-8"), file.name)


@functools.cache
def senses() -> Mapping[str, Senses]:
    """By the letters of a phrase: all that it may mean, in words.yaml, verbs.yaml and surroundings.yaml."""
    found: dict[str, dict[str, Any]] = {}
    for kind, values in read_table("words").items():
        for value, phrases in values.items():
            for phrase in phrases:
                found.setdefault(squeeze(str(phrase)), {}).setdefault(kind, value)
    surroundings = read_table("surroundings")
    for kind, value, phrase, confidence in _surroundings(surroundings):
        found.setdefault(squeeze(str(phrase)), {}).setdefault(kind, (value, confidence))
    for kind, entries in read_table("verbs").items():
        for entry in entries:
            for phrase, sense in _conjugate(kind, entry):
                found.setdefault(squeeze(phrase), {}).setdefault("verb", sense)
    for body, weights in read_table("vehicles")["bodies"].items():
        model = None if body == "Unclassed" else DslModel(body)
        for confidence, phrases in weights.items():
            for phrase in phrases:
                found.setdefault(squeeze(phrase), {}).setdefault("body", BodySense(model, confidence))
    return MappingProxyType(found)


@functools.cache
def table_words() -> frozenset[str]:
    """All words of which the phrases of the tables are made."""
    words = read_table("words").values()
    surroundings = read_table("surroundings")
    phrases = [str(phrase) for values in words for each in values.values() for phrase in each]
    phrases += [str(phrase) for _, _, phrase, _ in _surroundings(surroundings)]
    verbs = read_table("verbs")
    phrases += [way for kind, entries in verbs.items() for entry in entries for way, _ in _conjugate(kind, entry)]
    return frozenset(word for phrase in phrases for word in re.split(r"[ /-]", phrase.lower()))


@functools.cache
def verb_heads() -> frozenset[str]:
    """First words of the verbs of more than one word, in all forms: "smashed" of "smashed into"."""
    entries = [(kind, entry) for kind, entries in read_table("verbs").items() for entry in entries if " " in entry]
    phrases = (phrase for kind, entry in entries for phrase, _ in _conjugate(kind, entry))
    return frozenset(phrase.split(" ", 1)[0] for phrase in phrases)


def _surroundings(tables: Mapping[str, Any]) -> Iterator[tuple[str, str, str, float]]:
    for value, weights in tables["time"].items():
        for confidence, phrases in weights.items():
            yield from (("time", value, phrase, confidence) for phrase in phrases)
    for value, phrases in tables["weather"].items():
        yield from (("weather", value, phrase, 0.97) for phrase in phrases)


def _conjugate(kind: str, entry: str) -> Iterator[tuple[str, VerbSense]]:
    head, _, rest = entry.partition(" ")
    lemma, *irregular = head.split("/")
    if rest and lemma in _PREFIXES:  # the second word bends: "rear ended"
        second, _, tail = rest.partition(" ")
        for phrase, sense in _conjugate(kind, second):
            yield f"{lemma} {phrase} {tail}", VerbSense(kind, f"{lemma} {second}", sense.form)
        return
    stem = lemma[:-1] if lemma.endswith("e") and not lemma.endswith("ee") else lemma
    doubled = f"{lemma}{lemma[-1]}" if _doubles(lemma) else stem
    is_ied = lemma.endswith("y") and lemma[-2] not in _VOWELS
    third = f"{lemma[:-1]}ies" if is_ied else f"{lemma}{'es' if lemma.endswith(('s', 'sh', 'ch', 'x', 'o')) else 's'}"
    past = f"{lemma[:-1]}ied" if is_ied else f"{doubled}ed"
    forms = {"base": lemma, "s": third, "past": past, "participle": past, "ing": f"{lemma if is_ied else doubled}ing"}
    forms |= dict(zip(("past", "participle", "ing"), irregular, strict=False))
    if forms["past"] == forms["participle"]:
        forms["both"] = forms.pop("past")
        del forms["participle"]
    for own_form, word in forms.items():
        form = "both" if own_form == "base" and word == forms.get("both") else own_form  # "hit"
        yield f"{word} {rest}".strip(), VerbSense(kind, lemma, form)


def _doubles(lemma: str) -> bool:
    """Whether the last letter is said twice: "stopped"; not so "parked", "slowed", "reared"."""
    if not 2 < len(lemma) <= _SHORT or lemma[-1] in f"{_VOWELS}wxy" or lemma[-2] not in _VOWELS:
        return False
    return lemma[-3] not in _VOWELS


def is_known(word: str) -> bool:
    """Whether the tables know a word, written in full or short."""
    return squeeze(shorthand().get(word, word)) in senses()


@functools.cache
def shorthand() -> Mapping[str, str]:
    """What hasty writers write, and the word that they mean."""
    return MappingProxyType({short: word for word, shorts in read_table("shorthand").items() for short in shorts})


@functools.cache
def names() -> Mapping[str, tuple[NameSense, ...]]:
    """By its letters: makes, models and both together."""
    found: dict[str, dict[tuple[str, str | None], NameSense]] = {}
    table = read_table("vehicles")
    everyday = {squeeze(str(word)) for word in table["everyday"]}
    spellings: dict[str, list[str]] = {}
    for other, make in table["spellings"].items():
        spellings.setdefault(make, []).append(other)
    for make, content in table["makes"].items():
        own = content["make"]
        default = DslModel(own) if own else None
        ways = [make, *spellings.get(make, [])]
        for way in ways:
            key = squeeze(way)
            found.setdefault(key, {})[make, None] = NameSense(make, None, default, key in everyday)
        for field, models in content.items():
            for model in () if field == "make" else map(str, models):
                body = _CLASSES[field]
                key = squeeze(model)
                sense = NameSense(make, model.lower(), body, key in everyday or key.isdigit() or len(key) <= 2)
                if "body" not in senses().get(key, {}):  # "van" is a van, of whatever make
                    found.setdefault(key, {}).setdefault((make, model.lower()), sense)
                for way in ways:
                    full = squeeze(way) + key
                    found.setdefault(full, {}).setdefault(
                        (make, model.lower()), NameSense(make, model.lower(), body, is_everyday=False)
                    )
    return MappingProxyType({key: tuple(each.values()) for key, each in found.items()})


@functools.cache
def _long_words() -> Mapping[str, tuple[str, ...]]:
    """Single words of the tables that are long enough to be told when mistyped, by each way to leave a letter out."""
    ways: dict[str, list[str]] = {}
    words = {key for key, kinds in senses().items() if key.isalpha() and len(key) >= _FUZZY_FROM}
    words |= {
        key
        for key, each in names().items()
        if len(key) >= _FUZZY_FROM and key.isalpha() and all(sense.model is None for sense in each)
    }
    for word in sorted(words):
        for way in _shortened(word):
            ways.setdefault(way, []).append(word)
    return {way: tuple(found) for way, found in ways.items()}


def _shortened(word: str) -> set[str]:
    return {word, *(word[:place] + word[place + 1 :] for place in range(1, len(word)))}


@functools.lru_cache(maxsize=4096)
def mend(word: str, *, is_word: bool = False) -> str | None:
    """The word of the tables that one stands for that is no word; None where there is none, or more than one.

    Args:
        word: in small letters.
        is_word: whether it may be a rare word as it is; then one wrong letter is no slip: "sleeper", "curbed".
    """
    if len(word) < _FUZZY_FROM or not word.isalpha():
        return None
    slips: dict[int, set[str]] = {}
    for way in _shortened(word):
        for meant in _long_words().get(way, ()):
            slips.setdefault(_slip(word, meant), set()).add(meant)
    slips.pop(_NO_SLIP, None)
    if is_word:
        slips.pop(_WRONG_LETTER, None)
    found = slips[min(slips)] if slips else set()
    return found.pop() if len(found) == 1 else None


def _slip(word: str, meant: str) -> int:
    """How a word was mistyped, the likeliest way first: letters swapped, one left out or doubled, one wrong."""
    if abs(len(word) - len(meant)) > 1 or word[0] != meant[0] or f"{word}s" == meant or f"{meant}s" == word:
        return _NO_SLIP
    if len(word) != len(meant):
        longer, shorter = sorted((word, meant), key=len, reverse=True)
        return 1 if any(longer[:place] + longer[place + 1 :] == shorter for place in range(len(longer))) else _NO_SLIP
    wrong = [place for place, (one, other) in enumerate(zip(word, meant, strict=True)) if one != other]
    if len(wrong) == 2 and wrong[1] == wrong[0] + 1 and word[wrong[0]] == meant[wrong[1]]:
        return 0 if word[wrong[1]] == meant[wrong[0]] else _NO_SLIP
    return _WRONG_LETTER if len(wrong) == 1 else _NO_SLIP


@functools.cache
def word_set(name: str) -> frozenset[str]:
    """A small set of words that a rule looks for."""
    return frozenset(read_table("sets")[name])
