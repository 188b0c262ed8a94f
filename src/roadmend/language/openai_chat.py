"""Any endpoint that speaks OpenAI's chat protocol."""

import base64
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import openai
from openai.types.chat import ChatCompletion
from pydantic import ConfigDict, Field, SecretStr

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import check_settings
from roadmend.core.yaml_file import read_fields
from roadmend.language.chat import AnswerError, Image, RefusalError, Reply, Request, UnavailableError

_LOGGER = logging.getLogger(__name__)
_ENVIRONMENT = {
    "base_url": "OPENAI_BASE_URL",
    "model": "OPENAI_MODEL",
    "embedding_model": "OPENAI_EMBEDDING_MODEL",
    "api_key": "OPENAI_API_KEY",
}
_MEND = "see config/language/openai.yaml"


class OpenAISettings(Parameters):
    """Where the endpoint is and how to ask it; the field's names are those of config/language/openai.yaml."""

    model_config = ConfigDict(strict=False, hide_input_in_errors=True)  # the input may be a key

    base_url: str = Field(default="https://api.openai.com/v1", pattern=r"^https?://")
    model: str = Field(default="gpt-4o", min_length=1)
    embedding_model: str = Field(default="text-embedding-3-small", min_length=1)
    api_key: SecretStr
    timeout: float = Field(default=60.0, gt=0, le=3600, description="[s] of one attempt")
    attempts: int = Field(default=5, ge=1, le=20)
    input_price: float | None = Field(default=None, ge=0, description="[US dollars per million tokens]")
    output_price: float | None = Field(default=None, ge=0, description="[US dollars per million tokens]")


def read_openai_settings(file: Path | None, environment: Mapping[str, str] = os.environ) -> OpenAISettings:
    """Parameters from a file and the environment, which wins.

    Raises:
        InputError: the file is unusable, or there is no key.
    """
    content = read_fields(file, _MEND) if file is not None else {}
    content |= {name: environment[variable] for name, variable in _ENVIRONMENT.items() if environment.get(variable)}
    if not content.get("api_key"):
        raise InputError(
            "OPENAI_API_KEY", "is not set", "set it in the environment; a local server that wants no key takes any word"
        )
    return check_settings(content, OpenAISettings, str(file) if file is not None else "environment", _MEND)


def client_of(settings: OpenAISettings) -> openai.OpenAI:
    """A client.

    Retries, growing pauses and the server's Retry-After are its own; a time-out, 408, 409, 429 and every 5xx are tried
    again.
    """
    return openai.OpenAI(
        base_url=settings.base_url,
        api_key=settings.api_key.get_secret_value(),
        timeout=settings.timeout,
        max_retries=settings.attempts - 1,
    )


@contextmanager
def clear_errors(settings: OpenAISettings, lack: str) -> Iterator[None]:
    """Turns the client's errors into ours, none of which holds the key.

    Args:
        settings: of the client.
        lack: what was not sent, where something else was.

    Raises:
        UnavailableError: no answer, as often as it was tried.
        AnswerError: the answer is something else.
    """

    def without_key(text: str) -> str:
        return text.replace(settings.api_key.get_secret_value(), "[key]")

    try:
        yield
    except openai.APITimeoutError:
        raise UnavailableError(
            f"{settings.base_url} did not answer within {settings.timeout:g} s, tried {settings.attempts} times"
        ) from None
    except openai.APIStatusError as error:
        problem = without_key(error.message)
        raise UnavailableError(f"{settings.base_url} answered {error.status_code}: {problem}") from None
    except openai.APIConnectionError as error:
        problem = without_key(str(error.__cause__ or error))
        raise UnavailableError(f"{settings.base_url} cannot be reached: {problem}") from None
    except (openai.OpenAIError, ValueError) as error:
        raise AnswerError(f"{settings.base_url} sent {lack}: {without_key(str(error))[:200]}") from None


class OpenAIModel:
    """Asks an endpoint.

    Args:
        settings: see ``OpenAISettings``.
    """

    def __init__(self, settings: OpenAISettings) -> None:
        self.settings = settings
        self.client = client_of(settings)

    @property
    def identity(self) -> str:
        """What tells it from another model."""
        return f"{self.settings.base_url} {self.settings.model}"

    def ask(self, request: Request) -> Reply:
        """Ask for one completion.

        Raises:
            RefusalError: the model declined.
            UnavailableError: no answer, as often as it was tried.
            AnswerError: the answer is cut off, empty, or no chat completion.
        """
        body: Any = {
            "model": self.settings.model,
            "messages": [
                {"role": message.role.value, "content": [_part(part) for part in message.parts]}
                for message in request.messages
            ],
            "response_format": {
                "type": "json_schema",
                "json_schema": {"name": request.purpose, "strict": True, "schema": dict(request.schema)},
            },
            "temperature": 0,
        }
        with clear_errors(self.settings, "no chat completion"):
            completion = self.client.chat.completions.create(**body)
        return self._reply(completion, request.purpose)

    def _reply(self, completion: ChatCompletion, purpose: str) -> Reply:
        choices = getattr(completion, "choices", None)
        if not choices or getattr(choices[0], "message", None) is None:
            raise AnswerError(f"{self.settings.base_url} sent a completion without a choice")
        choice = choices[0]
        if choice.message.refusal:
            raise RefusalError(f"the model declined: {choice.message.refusal[:200]}")
        if choice.finish_reason == "content_filter":
            raise RefusalError("a content filter of the endpoint withheld the answer")
        if choice.finish_reason == "length":
            raise AnswerError("the answer was cut off at the endpoint's limit of tokens")
        if not choice.message.content:
            raise AnswerError("the answer is empty")
        usage = completion.usage
        given, made = (usage.prompt_tokens, usage.completion_tokens) if usage is not None else (0, 0)
        cost = self._cost(given, made)
        price = "" if cost is None else f", {cost:.6f} US dollars"
        _LOGGER.info("%s by %s: %d tokens in, %d out%s", purpose, completion.model, given, made, price)
        return Reply(choice.message.content, completion.model, given, made, cost)

    def _cost(self, given: int, made: int) -> float | None:
        if self.settings.input_price is None or self.settings.output_price is None:
            return None
        return (given * self.settings.input_price + made * self.settings.output_price) / 1e6


def _part(part: str | Image) -> dict[str, Any]:
    if isinstance(part, str):
        return {"type": "text", "text": part}
    data = base64.b64encode(part.data).decode()
    return {"type": "image_url", "image_url": {"url": f"data:{part.media_type};base64,{data}"}}
