"""The interface to a language model: messages with text and images in, text that fits a schema out; and what can fail."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from roadmend.core.errors import RoadmendError


class ChatRole(StrEnum):
    """Who speaks."""

    SYSTEM = "system"
    USER = "user"
    ASSISTANT = "assistant"


@dataclass(frozen=True, slots=True)
class Image:
    """A picture as a part of a message.

    Attributes:
        data: the file's content.
        media_type: for instance "image/png".
    """

    data: bytes
    media_type: str


@dataclass(frozen=True, slots=True)
class ChatMessage:
    """One turn of a conversation; its parts are texts and images."""

    role: ChatRole
    parts: tuple[str | Image, ...]


@dataclass(frozen=True, slots=True)
class Request:
    """A conversation and what its continuation has to look like.

    Attributes:
        purpose: what is asked for, in a word; the schema goes by this name.
        messages: so far.
        schema: JSON schema of the answer.
    """

    purpose: str
    messages: tuple[ChatMessage, ...]
    schema: Mapping[str, Any]

    def as_record(self) -> dict[str, Any]:
        """Plain data; an image is represented by its digest."""
        return {
            "purpose": self.purpose,
            "messages": [
                {"role": message.role.value, "parts": [_record(part) for part in message.parts]}
                for message in self.messages
            ],
            "schema": dict(self.schema),
        }

    def digest(self) -> str:
        """The same for the same request, whatever answers it."""
        return hashlib.sha256(json.dumps(self.as_record(), sort_keys=True).encode()).hexdigest()


def _record(part: str | Image) -> str | dict[str, str]:
    if isinstance(part, str):
        return part
    return {"image": part.media_type, "sha256": hashlib.sha256(part.data).hexdigest()}


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer.

    Attributes:
        text: JSON, if the model kept to the schema.
        model: that answered, by its own name.
        input_tokens: as the endpoint counts them; 0 where it does not.
        output_tokens: likewise.
        cost: [US dollars], where prices are configured.
        left_out: what of the request the endpoint does not take and was not sent.
    """

    text: str
    model: str
    input_tokens: int = 0
    output_tokens: int = 0
    cost: float | None = None
    left_out: tuple[str, ...] = ()


class ChatModel(Protocol):
    """Something that answers."""

    def ask(self, request: Request) -> Reply:
        """Answer one request.

        Raises:
            LanguageError: there is no usable answer.
        """


class LanguageError(RoadmendError):
    """A language model gave no usable answer."""


class RefusalError(LanguageError):
    """The model, or a filter in front of it, declined to answer."""


class UnavailableError(LanguageError):
    """The endpoint did not answer, or answered with an error, as often as it was tried."""


class AnswerError(LanguageError):
    """The answer is cut off or is not what was asked for."""


class NotRecordedError(LanguageError):
    """A replay was asked something that its recording does not hold."""
