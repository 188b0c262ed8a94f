"""Any endpoint that speaks OpenAI's chat protocol."""

import json
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx2
import openai
from pydantic import ConfigDict, Field, SecretStr, ValidationError, field_validator

from roadmend.core.bounds import REPLY, Bounds
from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import describe, first_fault
from roadmend.core.yaml_file import read_fields
from roadmend.language.answer_text import json_in
from roadmend.language.chat import AnswerError, LanguageError, RefusalError, Reply, Request, UnavailableError
from roadmend.language.completion import FILTERED, one_line, read_completion
from roadmend.language.endpoint_habits import EndpointHabits
from roadmend.language.http_client import TooLargeError, bounded_client

_LOGGER = logging.getLogger(__name__)
_ENVIRONMENT = {
    "base_url": "OPENAI_BASE_URL",
    "model": "OPENAI_MODEL",
    "embedding_model": "OPENAI_EMBEDDING_MODEL",
    "api_key": "OPENAI_API_KEY",
}
_TURNED_DOWN = frozenset({400, 404, 406, 413, 415, 422, 500, 501})  # perhaps for something that can be left out
_SHORTEST_KEY = 8  # [characters] shorter ones are words for a server that wants none, and occur in texts
_MEND = "see config/language/openai.yaml"


class OpenAISettings(Parameters):
    """Where the endpoint is and how to ask it; the field's names are those of config/language/openai.yaml."""

    # The input may be a key. A line end behind a value comes from the file that it was read from.
    model_config = ConfigDict(strict=False, hide_input_in_errors=True, str_strip_whitespace=True)

    base_url: str = Field(default="https://api.openai.com/v1", pattern=r"^https?://")
    model: str = Field(default="gpt-4o", min_length=1)
    embedding_model: str = Field(default="text-embedding-3-small", min_length=1)
    api_key: SecretStr
    timeout: float = Field(default=60.0, gt=0, le=3600, description="[s] of one attempt")
    attempts: int = Field(default=5, ge=1, le=20)
    max_tokens: int | None = Field(default=None, ge=1, description="of one answer; None leaves it to the endpoint")
    input_price: float | None = Field(default=None, ge=0, description="[US dollars per million tokens]")
    output_price: float | None = Field(default=None, ge=0, description="[US dollars per million tokens]")

    @field_validator("base_url")
    @classmethod
    def _is_address(cls, value: str) -> str:
        """What the client would stumble over; without its words, for there may be a password in the address."""
        try:
            host, port = httpx2.URL(value).host, urlsplit(value).port
        except (httpx2.InvalidURL, ValueError):
            host, port = "", None
        if not host or port == 0:
            raise ValueError("is no address with a host and perhaps a port, such as http://localhost:8000/v1")
        return value

    @field_validator("api_key")
    @classmethod
    def _is_key(cls, value: SecretStr) -> SecretStr:
        """What stands in a header; of anything else the client complains in words that hold it in another form."""
        key = value.get_secret_value().strip()
        if not key or not (key.isascii() and key.isprintable()):
            raise ValueError("is no key: one is made of letters, digits and signs of ASCII alone, in one line")
        return SecretStr(key)

    @property
    def place(self) -> str:
        """The endpoint as messages and records call it: without a name and a password in its address."""
        parts = urlsplit(self.base_url)
        return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}{parts.path}"

    def without_key(self, text: str) -> str:
        """A text of the endpoint, which may well repeat the key."""
        key = self.api_key.get_secret_value()
        if len(key) < _SHORTEST_KEY:
            return text
        for form in (json.dumps(key)[1:-1], repr(key)[1:-1], key):  # as it stands in JSON, and in an exception's words
            text = text.replace(form, "[key]")
        return text


def read_openai_settings(file: Path | None, environment: Mapping[str, str] = os.environ) -> OpenAISettings:
    """Parameters from a file and the environment, which wins.

    Raises:
        InputError: the file or a variable of the environment is unusable, or there is no key.
    """
    content = read_fields(file, _MEND) if file is not None else {}
    given = {name: environment.get(variable, "").strip() for name, variable in _ENVIRONMENT.items()}
    given = {name: value for name, value in given.items() if value}
    content |= given
    if not content.get("api_key"):
        raise InputError(
            "OPENAI_API_KEY", "is not set", "set it in the environment; a local server that wants no key takes any word"
        )
    try:
        return OpenAISettings.model_validate(content)
    except ValidationError as error:
        place, problem = first_fault(error, OpenAISettings)
        if place in given:
            raise InputError(_ENVIRONMENT[place], problem, _MEND) from None
        raise InputError(str(file), describe(error, OpenAISettings), _MEND) from None


def client_of(settings: OpenAISettings, bounds: Bounds = REPLY) -> openai.OpenAI:
    """A client.

    Retries, growing pauses and the server's Retry-After are its own; a time-out, 408, 409, 429 and every 5xx are tried
    again.

    Args:
        settings: of the endpoint.
        bounds: of one of its answers.
    """
    return openai.OpenAI(
        base_url=settings.base_url,
        api_key=settings.api_key.get_secret_value(),
        timeout=settings.timeout,
        max_retries=settings.attempts - 1,
        http_client=bounded_client(settings.timeout, bounds),
    )


@contextmanager
def clear_errors(settings: OpenAISettings, lack: str) -> Iterator[None]:
    """Turns the client's errors into ours, each one line, none of which holds the key.

    Args:
        settings: of the client.
        lack: what was not sent, where something else was.

    Raises:
        UnavailableError: no answer, as often as it was tried.
        RefusalError: the endpoint's filter turned the request down.
        AnswerError: the answer is something else.
    """
    place = settings.place
    try:
        yield
    except openai.APITimeoutError:
        raise UnavailableError(
            f"{place} did not answer within {settings.timeout:g} s, tried {settings.attempts} times"
        ) from None
    except openai.APIStatusError as error:
        problem = one_line(settings.without_key(_complaint(error)))
        if FILTERED in str(error.body):
            raise RefusalError(f"{place}: a content filter turned the request down: {problem}") from None
        raise UnavailableError(f"{place} answered {error.status_code}: {problem}") from None
    except openai.APIConnectionError as error:
        problem = one_line(settings.without_key(str(error.__cause__ or error)))
        raise UnavailableError(f"{place} cannot be reached: {problem}") from None
    except TooLargeError as error:
        raise AnswerError(f"{place} sent {lack}: {error}") from None
    except (openai.OpenAIError, ValueError) as error:
        raise AnswerError(f"{place} sent {lack}: {one_line(settings.without_key(str(error)))}") from None


def _complaint(error: openai.APIStatusError) -> str:
    """What an endpoint says is wrong; where it is no JSON, the client leaves that out of its message."""
    return error.message if isinstance(error.body, Mapping) else error.response.text.strip() or error.message


class OpenAIModel:
    """Asks an endpoint, and remembers what it does not take.

    Args:
        settings: see ``OpenAISettings``.
    """

    def __init__(self, settings: OpenAISettings) -> None:
        self.settings = settings
        self.client = client_of(settings)
        self.habits = EndpointHabits()

    @property
    def identity(self) -> str:
        """What tells it from another model."""
        return f"{self.settings.place} {self.settings.model}"

    def ask(self, request: Request) -> Reply:
        """Ask for one completion.

        Raises:
            RefusalError: the model or a filter declined.
            UnavailableError: no answer, as often as it was tried.
            AnswerError: the answer is cut off, empty, too large, or no chat completion.
        """
        with clear_errors(self.settings, "no chat completion"):
            data, content_type, habits = self._send(request)
        try:
            completion = read_completion(data, content_type)
            text = json_in(completion.text, request.schema)
        except LanguageError as error:
            raise type(error)(f"{self.settings.place}: {self.settings.without_key(str(error))}") from None
        given, made = completion.input_tokens, completion.output_tokens
        cost = self._cost(given, made)
        price = "" if cost is None else f", {cost:.6f} US dollars"
        model = self.settings.without_key(completion.model) or self.settings.model
        _LOGGER.info("%s by %s: %d tokens in, %d out%s", request.purpose, model, given, made, price)
        return Reply(self.settings.without_key(text), model, given, made, cost, habits.left_out(request))

    def _send(self, request: Request) -> tuple[bytes, str, EndpointHabits]:
        """The body of an answer and its type, and what the endpoint took of the request."""
        habits = self.habits
        while True:
            body: Any = {"model": self.settings.model, **habits.body(request, self.settings.max_tokens)}
            try:
                response = self.client.chat.completions.with_raw_response.create(**body).http_response
            except openai.APIStatusError as error:
                lesser = None
                if error.status_code in _TURNED_DOWN and FILTERED not in str(error.body):
                    lesser = habits.after(_complaint(error), request, self.settings.max_tokens)
                if lesser is None:
                    raise
                told = one_line(self.settings.without_key(_complaint(error)))
                _LOGGER.info("%s: %s; asked again without", self.settings.place, told)
                habits = lesser
                continue
            self.habits = habits.lasting
            return response.content, response.headers.get("content-type", ""), habits

    def _cost(self, given: int, made: int) -> float | None:
        if self.settings.input_price is None or self.settings.output_price is None:
            return None
        return (given * self.settings.input_price + made * self.settings.output_price) / 1e6
