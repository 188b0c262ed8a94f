"""What an endpoint takes of a request: all of it, until it complains of a part by name."""

import base64
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from roadmend.language.chat import ChatMessage, ChatRole, Image, Request

PICTURES = "pictures"  # what a reply's ``left_out`` calls them


class AnswerForm(StrEnum):
    """How the form of the answer is asked for, from the strictest to the laxest."""

    JSON_SCHEMA = "json_schema"
    JSON_OBJECT = "json_object"
    IN_WORDS = "in words"


_LAXER = {AnswerForm.JSON_SCHEMA: AnswerForm.JSON_OBJECT, AnswerForm.JSON_OBJECT: AnswerForm.IN_WORDS}
_NEXT_LIMIT = {"max_completion_tokens": "max_tokens", "max_tokens": None}
# By what words an endpoint's complaint is known. Servers name the parameter, or what they lack for it.
_OF_FORM = ("response_format", "json_schema", "json_object", "json mode", "structured output", "guided", "grammar")
_OF_IMAGES = (
    "image",
    "vision",
    "multimodal",
    "multi-modal",
    "mmproj",
    "expected a string",
    "must be a string",
    "payload too large",
    "entity too large",
)
# Such words are of a picture, or of pictures together, and say nothing of the next ones.
_OF_ONE_PICTURE = re.compile(
    r"too (large|big|many)|at most [1-9]|\b(exceed|format|mime|media.type|size|dimension|resolution|pixel|corrupt)"
    r"|\b(decode|decoding)\b|\b(identify|load|process|invalid|unsupported) image\b"
)
_OF_ROLES = ("system role", "system message", "roles must alternate", "alternate user/assistant")
_NO_PICTURE = "[A picture belongs here. The endpoint does not take it, so go by the text alone.]"


@dataclass(frozen=True, slots=True)
class EndpointHabits:
    """What an endpoint is known to take.

    Attributes:
        form: how it can be told the form of the answer.
        images: whether pictures may be sent.
        these_images: whether those of the request at hand may be; it says nothing of other requests.
        temperature: whether it may be set.
        limit: name of the parameter that bounds the answer; None for no bound.
        alternates: whether roles have to alternate between user and assistant, with no system among them.
    """

    form: AnswerForm = AnswerForm.JSON_SCHEMA
    images: bool = True
    these_images: bool = True
    temperature: bool = True
    limit: str | None = "max_completion_tokens"
    alternates: bool = False

    def after(self, complaint: str, request: Request, max_tokens: int | None) -> "EndpointHabits | None":
        """What to try after a request was turned down; None if the complaint names nothing that could be left out.

        Args:
            complaint: of the endpoint.
            request: that it turned down.
            max_tokens: bound of the answer, where one is asked for.
        """
        said = complaint.lower()
        if self._sends_images and has_images(request) and any(word in said for word in _OF_IMAGES):
            return replace(self, these_images=False) if _OF_ONE_PICTURE.search(said) else replace(self, images=False)
        if self.form in _LAXER and any(word in said for word in _OF_FORM):
            return replace(self, form=_LAXER[self.form])
        if self.temperature and "temperature" in said:
            return replace(self, temperature=False)
        if max_tokens is not None and self.limit is not None and self.limit in said:
            return replace(self, limit=_NEXT_LIMIT[self.limit])
        if not self.alternates and any(word in said for word in _OF_ROLES):
            return replace(self, alternates=True)
        return None

    @property
    def lasting(self) -> "EndpointHabits":
        """What is to be remembered for other requests."""
        return replace(self, these_images=True)

    @property
    def _sends_images(self) -> bool:
        return self.images and self.these_images

    def body(self, request: Request, max_tokens: int | None) -> dict[str, Any]:
        """The fields of a request to the endpoint, its model apart."""
        messages = [*request.messages]
        if self.form is not AnswerForm.JSON_SCHEMA:
            messages.insert(0, ChatMessage(ChatRole.SYSTEM, (_in_words(request.schema),)))
        if self.alternates:
            messages = _alternating(messages)
        content: dict[str, Any] = {"messages": [self._message(message) for message in messages]}
        if self.form is AnswerForm.JSON_SCHEMA:
            schema = {"name": request.purpose, "strict": True, "schema": dict(request.schema)}
            content["response_format"] = {"type": "json_schema", "json_schema": schema}
        elif self.form is AnswerForm.JSON_OBJECT:
            content["response_format"] = {"type": "json_object"}
        if self.temperature:
            content["temperature"] = 0
        if max_tokens is not None and self.limit is not None:
            content[self.limit] = max_tokens
        return content

    def left_out(self, request: Request) -> tuple[str, ...]:
        """What of a request is not sent as it was meant."""
        lacks = []
        if not self._sends_images and has_images(request):
            lacks.append(PICTURES)
        if self.form is not AnswerForm.JSON_SCHEMA:
            lacks.append("the schema as a parameter")
        if not self.temperature:
            lacks.append("temperature 0")
        return tuple(lacks)

    def _message(self, message: ChatMessage) -> dict[str, Any]:
        parts = [part if isinstance(part, str) or self._sends_images else _NO_PICTURE for part in message.parts]
        texts = [part for part in parts if isinstance(part, str)]
        if len(texts) == len(parts):  # a plain text is what every endpoint takes
            return {"role": message.role.value, "content": "\n\n".join(texts)}
        return {"role": message.role.value, "content": [_part(part) for part in parts]}


def has_images(request: Request) -> bool:
    """Whether pictures are a part of a request."""
    return any(isinstance(part, Image) for message in request.messages for part in message.parts)


def _in_words(schema: Mapping[str, Any]) -> str:
    return (
        "Answer with one JSON object and nothing before or after it. It has to fit this JSON schema: "
        f"{json.dumps(schema, ensure_ascii=False)}"
    )


def _alternating(messages: list[ChatMessage]) -> list[ChatMessage]:
    """Messages of which no two neighbours have one role, and none that of the system."""
    joined: list[ChatMessage] = []
    for message in messages:
        role = ChatRole.USER if message.role is ChatRole.SYSTEM else message.role
        if joined and joined[-1].role is role:
            joined[-1] = ChatMessage(role, (*joined[-1].parts, *message.parts))
        else:
            joined.append(ChatMessage(role, message.parts))
    return joined


def _part(part: str | Image) -> dict[str, Any]:
    if isinstance(part, str):
        return {"type": "text", "text": part}
    data = base64.b64encode(part.data).decode()
    return {"type": "image_url", "image_url": {"url": f"data:{part.media_type};base64,{data}"}}
