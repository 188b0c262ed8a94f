"""The body of a chat completion, read warily: endpoints that speak OpenAI's protocol speak it more or less."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.language.chat import AnswerError, RefusalError, UnavailableError

_SHOWN = 200  # [characters] of what an endpoint says
_LOOKED_THROUGH = 5000  # [characters] of a page, for the patterns below look through the rest from every begin
_TITLE = re.compile(r"<title[^>]*>(.*?)</title>", re.IGNORECASE | re.DOTALL)
_MARKUP = re.compile(r"<[^>]*>")
FILTERED = "content_filter"  # an endpoint's word for an answer, or a question, that it withholds


@dataclass(frozen=True, slots=True)
class Completion:
    """What is wanted of a completion.

    Attributes:
        text: of the first choice.
        model: that wrote it; empty where the endpoint does not say.
        input_tokens: 0 where the endpoint does not count them.
        output_tokens: likewise.
    """

    text: str
    model: str
    input_tokens: int
    output_tokens: int


def read_completion(data: bytes, content_type: str) -> Completion:
    """Read a body.

    Args:
        data: the body.
        content_type: that it is said to have; what it holds counts for more.

    Raises:
        AnswerError: it is no completion, or one that is empty or cut off.
        RefusalError: the model or a filter declined.
        UnavailableError: it is an error, sent as if nothing were wrong.
    """
    content = _content(data, content_type)
    choices = content.get("choices")
    error = content.get("error")
    if error and not choices:
        if FILTERED in str(error):
            raise RefusalError("a content filter of the endpoint turned the request down")
        raise UnavailableError(f"an error in place of an answer: {one_line(_message_of(error))}")
    choice = choices[0] if isinstance(choices, list) and choices else None
    message = choice.get("message") if isinstance(choice, Mapping) else None
    if not isinstance(choice, Mapping) or not isinstance(message, Mapping):
        raise AnswerError("a completion without a choice")
    if message.get("refusal"):
        raise RefusalError(f"the model declined: {one_line(str(message['refusal']))}")
    reason = choice.get("finish_reason")
    if reason == FILTERED:
        raise RefusalError("a content filter of the endpoint withheld the answer")
    if reason == "length":
        raise AnswerError("the answer was cut off at the endpoint's limit of tokens")
    text = _text_of(message.get("content"))
    if not text.strip():
        raise AnswerError("the answer is empty")
    usage = content.get("usage")
    counts = usage if isinstance(usage, Mapping) else {}
    model = content.get("model")
    return Completion(
        text,
        model if isinstance(model, str) else "",
        _count(counts.get("prompt_tokens")),
        _count(counts.get("completion_tokens")),
    )


def _content(data: bytes, content_type: str) -> Mapping[str, Any]:
    if not data.strip():
        raise AnswerError("no chat completion: the body is empty")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise AnswerError(f"no chat completion: byte {error.start} of the body is no UTF-8") from None
    try:
        content = parse_json(text, "the body")
    except InputError as error:
        raise AnswerError(f"no chat completion: {_kind(text, content_type, error)}") from None
    if not isinstance(content, Mapping):
        raise AnswerError("no chat completion: the body is no JSON object")
    return content


def _kind(text: str, content_type: str, error: InputError) -> str:
    """What a body is that is no JSON."""
    begin = text.lstrip()[:200].lower()
    if begin.startswith("<"):
        return f"a page for people: {one_line(text)}"
    if content_type.startswith("text/event-stream") or begin.startswith(("data:", "event:", ":")):
        return "a stream of events, which was not asked for"
    return f"{error.what} (sent as {content_type or 'nothing in particular'})"


def _text_of(content: Any) -> str:
    if isinstance(content, str):
        return content
    if isinstance(content, list):  # some hand on the parts that their models write in
        parts = [part.get("text") for part in content if isinstance(part, Mapping) and part.get("type") == "text"]
        return "".join(part for part in parts if isinstance(part, str))
    return ""


def _message_of(error: Any) -> str:
    return str(error.get("message") or error) if isinstance(error, Mapping) else str(error)


def _count(value: Any) -> int:
    return value if isinstance(value, int) and value >= 0 else 0


def one_line(text: str) -> str:
    """What an endpoint says, short and on one line; of a page for people its title or its words."""
    if text.lstrip().startswith("<"):
        page = text[:_LOOKED_THROUGH]
        title = _TITLE.search(page)
        text = title[1] if title else _MARKUP.sub(" ", page)
    text = " ".join(text.split())
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
