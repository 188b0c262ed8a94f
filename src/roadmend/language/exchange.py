"""Exchanges with a language model on record, kept with every result; and a model that answers from a record."""

import hashlib
import io
import json
import threading
from collections import defaultdict, deque
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from roadmend.core.bounded_file import read_bytes, read_text
from roadmend.core.bounds import TEXT
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.language.chat import (
    AnswerError,
    ChatModel,
    LanguageError,
    NotRecordedError,
    RefusalError,
    Reply,
    Request,
    UnavailableError,
)

# What can fail, by the names that recordings have for it; who asks goes on after one, and gives up after another.
_KINDS = {kind.__name__: kind for kind in (AnswerError, RefusalError, UnavailableError, NotRecordedError)}


@dataclass(frozen=True, slots=True)
class Exchange:
    """A request and what came of it.

    Attributes:
        digest: of the request.
        request: as plain data.
        reply: None where there was none.
        error: what went wrong then.
        kind: of that error; None where it has none of its own, and in recordings that are older than this field.
    """

    digest: str
    request: Mapping[str, Any]
    reply: Reply | None
    error: str | None = None
    kind: str | None = None


_EXCHANGE = TypeAdapter(Exchange)


@dataclass(frozen=True, slots=True)
class Usage:
    """What a model took for a number of answers.

    Attributes:
        answers: that it gave.
        input_tokens: as the endpoint counts them.
        output_tokens: likewise.
        cost: [US dollars]; None where one of the answers has no price.
    """

    answers: int
    input_tokens: int
    output_tokens: int
    cost: float | None

    def __add__(self, other: "Usage") -> "Usage":
        cost = None if self.cost is None or other.cost is None else self.cost + other.cost
        return Usage(
            self.answers + other.answers,
            self.input_tokens + other.input_tokens,
            self.output_tokens + other.output_tokens,
            cost,
        )

    def __str__(self) -> str:
        price = "" if self.cost is None else f", {self.cost:.4f} US dollars"
        return f"{self.answers} answers, {self.input_tokens:,} tokens in, {self.output_tokens:,} out{price}"


def usage_of(exchanges: Iterable[Exchange]) -> dict[str, Usage]:
    """What exchanges took, by model."""
    replies = (exchange.reply for exchange in exchanges if exchange.reply is not None)
    return add_usages({reply.model: Usage(1, reply.input_tokens, reply.output_tokens, reply.cost)} for reply in replies)


def add_usages(usages: Iterable[Mapping[str, Usage]]) -> dict[str, Usage]:
    """The sums, by model."""
    total: dict[str, Usage] = {}
    for usage in usages:
        for model, more in usage.items():
            total[model] = total[model] + more if model in total else more
    return total


class RecordingModel:
    """A model that keeps what it was asked and what it answered.

    Args:
        model: that answers.
    """

    def __init__(self, model: ChatModel) -> None:
        self.model = model
        self.exchanges: list[Exchange] = []

    def ask(self, request: Request) -> Reply:
        """Pass a request on."""
        try:
            reply = self.model.ask(request)
        except LanguageError as error:
            kind = next((name for name, kind in _KINDS.items() if isinstance(error, kind)), None)
            self.exchanges.append(Exchange(request.digest(), request.as_record(), None, str(error), kind))
            raise
        self.exchanges.append(Exchange(request.digest(), request.as_record(), reply))
        return reply


def dump_exchanges(exchanges: Iterable[Exchange]) -> str:
    """One JSON object a line."""
    return "".join(json.dumps(asdict(exchange), ensure_ascii=False) + "\n" for exchange in exchanges)


def load_exchanges(path: Path) -> tuple[Exchange, ...]:
    """Read what ``dump_exchanges`` wrote.

    Raises:
        InputError: the file cannot be read or a line of it is no exchange.
    """
    mend = "give a recording of exchanges"
    # Not splitlines: what ends a line to Unicode stands within an answer as it is.
    lines = io.StringIO(read_text(path, TEXT, mend))
    exchanges = []
    for number, line in enumerate(lines, start=1):
        try:
            exchanges.append(_exchange(parse_json(line, f"{path}, line {number}")))
        except (InputError, KeyError, TypeError, ValidationError):
            raise InputError(f"{path}, line {number}", "is no exchange", mend) from None
    return tuple(exchanges)


def _exchange(content: Mapping[str, Any]) -> Exchange:
    given = {name: content[name] for name in ("digest", "request", "reply", "error")} | {"kind": content.get("kind")}
    if given["reply"] is not None:
        Reply(**given["reply"])  # has no other names than its own
    exchange = _EXCHANGE.validate_python(given)
    return exchange if exchange.kind in _KINDS else replace(exchange, kind=None)


ENDING = ".exchanges.jsonl"


class ReplayModel:
    """Answers what was recorded, in the order of the recording, and nothing else.

    Args:
        source: a recording, or a folder with recordings.

    Raises:
        InputError: there is no recording, or one of them is broken.
    """

    def __init__(self, source: Path) -> None:
        files = sorted(source.glob(f"*{ENDING}")) if source.is_dir() else [source]
        if not files:
            raise InputError(str(source), f"holds no recording (*{ENDING})", "give the folder of an earlier run")
        self.identity = hashlib.sha256(
            b"".join(read_bytes(file, TEXT, "give a recording of exchanges") for file in files)
        ).hexdigest()
        """What tells it from another recording."""
        self.files = tuple(files)
        self.left: dict[str, deque[Exchange]] = defaultdict(deque)
        self.lock = threading.Lock()
        for file in files:
            for exchange in load_exchanges(file):
                self.left[exchange.digest].append(exchange)

    def ask(self, request: Request) -> Reply:
        """Give the recorded answer.

        Raises:
            NotRecordedError: this was never asked, or not as often.
            LanguageError: the recorded exchange failed; of the kind that it failed with.
        """
        digest = request.digest()
        with self.lock:
            left = self.left.get(digest)
            exchange = left.popleft() if left else None
        if exchange is None:
            raise NotRecordedError(
                f"the recording has no (further) answer to this request for {request.purpose} ({digest[:12]}); "
                "it belongs to other reports, or to another version of the prompts"
            )
        if exchange.reply is None:
            kind = _KINDS.get(exchange.kind or "", LanguageError)
            raise kind(exchange.error or "the recorded exchange failed")
        return exchange.reply
