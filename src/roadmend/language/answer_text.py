"""The JSON object in the text of an answer: behind a model's thoughts, in a fence of Markdown, with prose around it."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.language.chat import AnswerError

_THOUGHTS = re.compile(r"<(think|thinking|thought|reasoning)>.*?</\1>", re.DOTALL | re.IGNORECASE)
_END_OF_THOUGHTS = re.compile(r"</(?:think|thinking|thought|reasoning)>", re.IGNORECASE)
_FENCE = re.compile(r"```[\w+-]*[ \t]*\n(.*?)\n?[ \t]*```", re.DOTALL)
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
    # Some servers take the opening mark away, since it stands in the template of the prompt.
    return _END_OF_THOUGHTS.split(_THOUGHTS.sub("", text))[-1]


def _fenced(text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    for match in _FENCE.finditer(text):
        content = _object(match[1])
        if content is not None:
            yield match[1].strip(), content


def _bare(text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Objects that stand in prose, each as far as it reaches; what stands within one is none of its own."""
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
        content = _object(text[begin:end])
        if content is not None:
            yield text[begin:end], content
        begin = end


def _object(text: str) -> dict[str, Any] | None:
    try:
        content = parse_json(text, "answer")
    except InputError:
        return None
    return content if isinstance(content, dict) else None
