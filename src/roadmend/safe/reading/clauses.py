"""Who does what: sentences cut into clauses, each with the vehicle that it is about."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from roadmend.safe.reading.text import Sentence

_NEW_SUBJECT = (
    r"(?:the (?:\w+ )?(?:driver|operator|front|rear|left|right|frontal|back|impact|\w+ plane)\b|v\d\b|both\b|it\b|"
    r"he\b|she\b|they\b|this (?:impact|caused)\b)"
)
_TRAVELING = (
    r"(?:also |who |which )?(?:traveling|heading|headed|going|driving) (?:[\w-]+ ){0,4}?(?:north|south|east|west)"
)
_BOUNDARY = re.compile(
    rf";\s*|,?\s+(?:while|when|as|but|before|after|until|whereas|then|causing|because)\s+(?={_NEW_SUBJECT})|"
    r",\s+(?=(?:and\s+)?(?:the (?:driver|operator|front|rear)\b|v\d\b(?!\s*,?\s*(?:and|or)\b)|both\b|he\b|she\b))|"
    r"\s+and\s+(?=(?:the (?:driver|operator|front|rear|left side|right side|frontal plane)\b|"
    r"v\d\b(?:, (?:an?|the) [^,;.]{2,60},)?(?=[^,;.]{0,40}?\b(?:was|were(?! both| all| each)|had|is|struck|"
    r"turned|continued|entered|did|drifted|came|began|traveled|attempted|proceeded|made|failed))))|"
    rf"(?:(?<=v\d)|(?<=v\d\))),?\s+(?={_TRAVELING})|,?\s+(?=(?:which|who|that)\s+(?:was|were|had|is|has)\b)|"
    r",\s+(?=(?:where|causing)\b)"
)
_LAST_NAMED = re.compile(r"\bv(\d)\)?(?:\s*\([^)]*\)|(?:,| was| is)? (?:an?|the) [^.;]*)?,?$")
_REFERENCE = re.compile(r"\bv(\d)\b")
_PRONOUN = re.compile(
    r"^(?:(?:and|when|as|while|before|after|but|then)\s+)?(?:he|she|it|they|this vehicle|the vehicle|"
    r"the driver(?! (?:of|in) v\d)|its|his|her|the (?:[\w-]+ ){1,3}of (?:its|his|her|the) (?:own )?(?:vehicle|car))\b"
)
_ASIDE = re.compile(
    r"\s*\((?!v\d|(?:north|south|east|west)(?:bound)?(?: to \w+)?\))[^)]*\)"
)  # counts of lanes, ages, belts
_PAIR = re.compile(r"\bv(\d), (?:an?|the) [^,;.]{2,60},? and v(\d), (?:an?|the) [^,;.]{2,60}, were (?:both )?")
_RELATIVE = re.compile(rf"^(?:(?:which|who|that)\b|{_TRAVELING})")
_PLACED = re.compile(
    r"^(?:while |and |as )?(?:ahead of|behind|in front of|following|in advance of|directly ahead of|"
    r"to the (?:left|right) of) v\d,?\s*(?:was|were)?\s*(?=.*\bv\d)"
)
_BOTH = re.compile(
    r"\b(?:both|the (?:2|3|4)) (?:vehicles|drivers|cars|motorists)\b|\ball (?:3|4|of the)? ?vehicles\b|"
    r"^(?:and |while )?both (?=were\b|had\b|of them\b)|\bv\d(?:,| and)[^.;]{0,20}\bv\d were (?:both )?"
)

_WERE_ALL = re.compile(r"\bwere (?:both|all|each)\b")
_KINDS = re.compile(r"\b(?:vehicle|car|sedan|van|minivan|pickup|truck|trailer|suv)\b")
_TOUCHED = re.compile(r"\b(?:was|struck|hit|impacted|contacted)\b")


@dataclass(frozen=True, slots=True)
class Clause:
    """Part of a sentence with one subject.

    Attributes:
        subjects: numbers of the vehicles that it is about; empty where it is about none.
        text: the part, in plain form.
        sentence: the sentence, as the report puts it.
    """

    subjects: tuple[int, ...]
    text: str
    sentence: str


def cut_clauses(sentences: Sequence[Sentence], numbers: Sequence[int]) -> tuple[Clause, ...]:
    """The clauses of a report, in order."""
    clauses: list[Clause] = []
    topic: tuple[int, ...] = ()  # what a pronoun at the start of the next sentence means
    for sentence in sentences:
        plain = _PAIR.sub(r"v\1 and v\2 were both ", _ASIDE.sub("", sentence.plain))
        subject: tuple[int, ...] = ()
        for text in filter(None, (part.strip() for part in _split(plain))):
            found = _subjects(text, numbers)
            if _RELATIVE.match(text) and clauses:
                # "struck v2, which was stopped": the last vehicle named is meant
                last = _LAST_NAMED.search(clauses[-1].text)
                found = (int(last[1]),) if last else ()
                clauses.append(Clause(_known(found, numbers), text, sentence.text))
                continue
            if _PRONOUN.match(text) and (subject or topic):
                found = subject or topic  # "it struck v2" is not about v2
            elif not found:
                found = subject
            elif not subject:
                topic = found
            subject = found
            clauses.append(Clause(_known(found, numbers), text, sentence.text))
    return tuple(clauses)


def _split(plain: str) -> list[str]:
    return _BOUNDARY.split(plain)


def _known(subjects: tuple[int, ...], numbers: Sequence[int]) -> tuple[int, ...]:
    return tuple(number for number in subjects if number in numbers)


def _subjects(text: str, numbers: Sequence[int]) -> tuple[int, ...]:
    all_of_them = _WERE_ALL.search(text)
    before = text[: all_of_them.start()] if all_of_them else ""
    named = tuple(dict.fromkeys(int(number) for number in _REFERENCE.findall(before)))
    if len(named) > 1 and not _TOUCHED.search(before):
        return named
    if all_of_them and not named and _KINDS.search(before):
        return tuple(numbers)  # "a van and a truck were both headed south"
    if _BOTH.search(text[:60]):
        named = tuple(dict.fromkeys(int(number) for number in _REFERENCE.findall(text[:60])))
        return named if len(named) > 1 else tuple(numbers)
    without_place = _PLACED.sub("", text)
    match = _REFERENCE.search(without_place)
    if match is None:
        return ()
    listed = re.match(r"(?:(?:,\s*|\s+)(?:and\s+)?v\d\b)+", without_place[match.end() :])
    rest = _REFERENCE.findall(listed[0]) if listed else []
    return tuple(dict.fromkeys((int(match[1]), *(int(number) for number in rest))))
