"""The JSON object in the text of an answer: behind a model's thoughts, in a fence of Markdown, with prose around it."""

import json
import re
from bisect import bisect
from collections.abc import Iterator, Mapping
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.language.chat import AnswerError

# Marks are looked for one by one: a pattern of a begin, anything and an end looks through the rest from every begin.
_MARK_OF_THOUGHTS = re.compile(r"<(/?)(think|thinking|thought|reasoning)>", re.IGNORECASE | re.ASCII)
_FENCE, _BEGIN_OF_FENCE = "```", re.compile(r"```[\w+-]*[ \t]*\n")
_PLACES = 200  # in a text where an object may begin, at most
_DECODER = json.JSONDecoder()


def json_in(text: str, schema: Mapping[str, Any]) -> str:
    """The object that a text hands over as its answer; the text itself where there is none.

    Thoughts are left aside, for what a model considers there it has not answered. Of what is left an object counts if it
    has the fields that the schema requires.

    Args:
        text: as the model wrote it.
        schema: JSON schema of the answer.

    Raises:
        AnswerError: there are several that differ, and nothing says which one is meant.
    """
    if _object(text) is not None:
        return text
    said = _without_thoughts(text)
    wanted = {*schema.get("required", ())}
    for candidates in (_fenced(said), _bare(said)):
        found = {json.dumps(content, sort_keys=True): part for part, content in candidates if wanted <= content.keys()}
        if len(found) > 1:
            raise AnswerError(f"the answer holds {len(found)} different JSON objects, one was asked for")
        if found:
            return next(iter(found.values()))
    return said.strip()


def _without_thoughts(text: str) -> str:
    found = [*_MARK_OF_THOUGHTS.finditer(text)]
    objects = [*_places(text)] if found else []  # a mark that is quoted in one of them is a part of what it says
    last = [bisect(objects, (mark.start(), 0)) - 1 for mark in found]
    own = [mark for mark, place in zip(found, last, strict=True) if place < 0 or mark.start() >= objects[place][1]]
    marks = [(*mark.span(), bool(mark[1]), mark[2].lower()) for mark in own]
    last_ends = {name: begin for begin, _, is_end, name in marks if is_end}
    parts: list[str] = []
    place, thinking = 0, ""
    for begin, end, is_end, name in marks:
        if not thinking and not is_end and last_ends.get(name, -1) > begin:
            parts.append(text[place:begin])
            thinking = name
        elif is_end and thinking in {name, ""}:
            if not thinking:
                # Some servers take the opening mark away, since it stands in the template of the prompt.
                parts.clear()
            place, thinking = end, ""
    return "".join(parts) + text[place:]


def _fenced(text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    begin = _BEGIN_OF_FENCE.search(text)
    while begin is not None:
        end = text.find(_FENCE, begin.end())
        if end < 0:
            return
        part = text[begin.end() : end].strip()
        content = _object(part)
        if content is not None:
            yield part, content
        begin = _BEGIN_OF_FENCE.search(text, end + len(_FENCE))


def _bare(text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Objects that stand in prose."""
    for begin, end in _places(text):
        content = _object(text[begin:end])
        if content is not None:
            yield text[begin:end], content


def _places(text: str) -> Iterator[tuple[int, int]]:
    """Begin and end of the objects in a text, each as far as it reaches; what stands within one is none of its own."""
    begin = 0
    for _ in range(_PLACES):
        begin = text.find("{", begin)
        if begin < 0:
            return
        try:
            _, end = _DECODER.raw_decode(text, begin)
        except (ValueError, RecursionError):
            begin += 1
            continue
        yield begin, end
        begin = end


def _object(text: str) -> dict[str, Any] | None:
    try:
        content = parse_json(text, "answer")
    except InputError:
        return None
    return content if isinstance(content, dict) else None
