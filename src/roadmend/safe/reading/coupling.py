"""Two names of one vehicle side by side: "Vehicle 1, a 2004 Honda Civic", "the car in front of me, a Toyota"."""

import itertools
from collections.abc import Sequence
from dataclasses import replace

from roadmend.safe.reading.cast import Description
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.tokens import Sentence, Words

_APPOSITION = 6  # words at most between two names of one vehicle
_OPENING = 2  # words at most before "me: a Ford"
_SEAT = 8  # words between a numbered driver and the car that she or he sits in


def couple(items: Words, row: Sequence[Mention]) -> None:
    """Give two names of one vehicle that stand side by side one description: "Vehicle 1, a 2004 Honda Civic"."""
    for one, other in itertools.pairwise(row):
        bracketed = items.at(other.first - 1).low == "(" and items.at(other.last + 1).low == ")"
        is_side = items[other.first].is_a("insured") or (other.kind is MentionKind.SELF and other.first == other.last)
        if bracketed and one.description is not None and is_side:
            is_self = other.kind is MentionKind.SELF
            one.description = replace(one.description, is_own=one.description.is_own or is_self)
            other.kind, other.twin = MentionKind.NAMED, one  # "a Hilux (claimant) that was entering"
    for one, other in itertools.pairwise(row):
        if one.description is None and other.description is not None and other.number is None:
            _take(items, one, other, other.description)
    for mention in row:
        after = items.cut(mention.last + 1, mention.last + 3)
        if mention.description is not None and after.at(0).low == "," and after.at(1).low in {"mine", "ours"}:
            mention.description = replace(mention.description, is_own=True)  # "Tundra, mine"
    for one, other in itertools.pairwise([each for each in row if each.description is not None]):
        between = items.cut(one.last + 1, other.first)
        if one.description is None or other.description is None or (one.number and other.number):
            continue
        named_again = bool(between) and all(item.is_a("thing") for item in between)
        named_again |= _is_placed(items, between, one, other) or _sits_in_new(between, one, other)
        if not named_again and (len(between) > _APPOSITION or not _is_apposition(between, other)):
            continue
        numbered = one.number or other.number
        if not numbered and (not other.is_new or one.description.contradicts(other.description)):
            continue
        one.description = other.description = one.description.merged(other.description)
        other.is_new, other.twin = one.is_new, one


def _take(items: Words, one: Mention, other: Mention, described: Description) -> None:
    """Give the writer or the other one what stands in brackets or behind a colon: "I (Tacoma)", "OV (also a pickup)"."""
    lead = items.at(one.last + 1).low
    between = items.cut(one.last + 2, other.first)
    follows = items.at(other.last + 1).low
    if items.cut(0, one.first).has("preposition", "ahead", "behind", "beside"):
        return  # "ahead of me: a sedan"
    closes = (
        follows in {")", ","}
        if lead == "("
        else one.first <= _OPENING and (lead in {":", "="} or lead == "," == follows)
    )
    if not closes or len(between) > 1 or (between and between[0].low not in word_set("apposition")):
        return
    if one.kind is MentionKind.SELF:
        other.description = replace(described, is_own=True)
    elif one.kind is MentionKind.OTHER:
        one.description, one.is_new, other.twin = replace(described, is_other=True), True, one


def _is_placed(items: Words, between: Words, one: Mention, other: Mention) -> bool:
    """Whether a name stands behind where the vehicle was: "the car in front of me, a Toyota Highlander, stopped"."""
    plain = one.description is not None and not one.description.names and one.number is None
    named = other.is_new and other.description is not None and bool(other.description.names)
    placed = 1 < len(between) <= _APPOSITION and between[0].is_a("ahead", "behind", "beside", "oncoming")
    ends = items.at(other.last + 1).low in {",", "", ")", ";", "-"} or items.at(other.last + 1).is_a(
        "auxiliary", "verb"
    )
    return plain and named and placed and between[-1].low == "," and ends


def _sits_in_new(between: Words, one: Mention, other: Mention) -> bool:
    """Whether a numbered driver sits in a vehicle that has no number: "D1 Harlan was s/b in a Dodge Ram"."""
    fresh = other.description is not None and (other.is_new or other.description.is_theirs) and other.number is None
    bare = one.number is not None and one.description is not None and not one.description.names
    led = 0 < len(between) <= _SEAT and between[-1].low in word_set("sits_in") - {"'s"}
    return fresh and bare and led and not between.has("relative") and not between.says({",", ";"} & {between.at(0).low})


def _is_apposition(between: Words, other: Mention) -> bool:
    if not between:
        return True
    is_copula = all(item.get("auxiliary") == "be" or item.low == ")" for item in between)
    has_mark = between.says(word_set("apposition_marks"))
    plain = all(item.low in word_set("apposition") or item.is_a("thing", "descriptor") for item in between)
    unknown = (
        other.is_new and len(between) <= 2 and all(not item.kinds and item.low.isalpha() for item in between)
    )  # "veh 1 unk pickup"
    return (is_copula and other.is_new) or (plain and has_mark) or unknown


def let_speak(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> None:
    """Tell each "I" whose it is where drivers speak one after the other: "Driver A: I was in my Polo"."""
    speaker: Mention | None = None
    for sentence, row in zip(sentences, found, strict=True):
        first = row[0] if row else None
        is_label = first is not None and first.number is not None and first.is_person and first.first == 0
        if first is not None and is_label and sentence.items.at(first.last + 1).low == ":":
            speaker = first
        for mention in row if speaker is not None else ():
            if mention.kind is MentionKind.SELF:
                mention.speaker = speaker
            elif mention.description is not None and mention.description.is_own and speaker is not None:
                mention.description = replace(mention.description, is_own=False, number=speaker.number)
