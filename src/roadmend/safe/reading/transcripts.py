"""Questions and their answers, as statements are taken down: a short answer is read together with what it answers."""

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from roadmend.safe.claims import Span
from roadmend.safe.reading.tokens import Item, Sentence, Words

_LABELS = 2  # sentences that begin with a speaker and a colon, from which a text is a transcript
_MOST_ANSWERED = 9  # words of an answer that is no statement of its own
_ASKED = re.compile(r"\s*[)'\"\u201d]*\?")
_YOU = {"you": "self", "your": "own", "yours": "own", "ya": "self"}
_MARKS = {"Q", "A"}
_SPEAKER = 3  # words at most before the colon


def join_answers(sentences: Sequence[Sentence], summary: str) -> list[Sentence]:
    """Put short answers behind their questions, and let "you" in a question be who answers."""
    questions = [_is_question(each, summary) for each in sentences]
    labels = [_label(each.items) for each in sentences]
    if sum(each.items.at(0).text == "Q" for each in sentences) >= _LABELS:
        labels = [label or each.items.at(0).text in _MARKS for label, each in zip(labels, sentences, strict=True)]
    is_transcript = sum(asked and bool(label) for asked, label in zip(questions, labels, strict=True)) >= _LABELS
    if not is_transcript:
        labels = [0] * len(labels)
    if is_transcript:  # "Speed limit, if you know it." - "Thirty-five."
        for place, (asked, answer) in enumerate(itertools.pairwise(sentences)):
            own = answer.items.cut(labels[place + 1])
            questions[place] |= asked.items.has("limit", "lane") and not asked.items.has("number") and own.has("number")
    return list(_joined(sentences, questions, labels, is_transcript=is_transcript))


def _joined(
    sentences: Sequence[Sentence], questions: Sequence[bool], labels: Sequence[int], *, is_transcript: bool
) -> Iterator[Sentence]:
    asked: Sentence | None = None
    for sentence, is_question, label in zip(sentences, questions, labels, strict=True):
        own = replace(sentence, items=sentence.items.cut(label)) if len(sentence.items) > label else sentence
        if is_question:
            if asked is not None:
                yield asked
            asked = replace(own, items=Words(map(_addressed, own.items))) if is_transcript else own
        elif asked is not None and _is_fragment(own.items):
            yield replace(asked, items=Words(asked.items + own.items), span=Span(asked.span.start, own.span.end))
            asked = None
        else:
            if asked is not None:
                yield asked
            asked = None
            yield own
    if asked is not None:
        yield asked


def _is_question(sentence: Sentence, summary: str) -> bool:
    return _ASKED.match(summary, sentence.span.end) is not None


def _label(items: Words) -> int:
    """Words of the speaker's name in front of a sentence, with its colon; 0 where there is none."""
    place = next((at for at, item in enumerate(items.cut(0, _SPEAKER + 1)) if item.low == ":"), 0)
    return place + 1 if place and not items[0].is_a("time", "weather", "limit", "lane", "road") else 0


def _addressed(item: Item) -> Item:
    word = _YOU.get(item.low)
    return item if word is None else replace(item, kinds={"pronoun": word})


def _is_fragment(items: Words) -> bool:
    """Whether an answer needs its question: "Forty-five", "North, on Elm"."""
    if items.at(0).is_a("number", "bound", "compass", "time", "weather") and len(items) <= _MOST_ANSWERED:
        return True
    has_subject = (
        items.has("auxiliary")
        or any(item.low.endswith("n't") for item in items)
        or any(item.get("pronoun") in {"self", "it", "one"} for item in items)
    )
    return len(items) <= _MOST_ANSWERED and not has_subject
