"""A language model to test with: a server on this machine that speaks the real protocol."""

import json
from contextlib import contextmanager

from roadmend.language.exchange import RecordingModel
from roadmend.language.openai_chat import OpenAIModel, OpenAISettings

from ..language.server import completion, serving  # noqa: TID252 - one server for all rooms

KEY = "sk-very-secret"


def as_completion(answer):
    """A completion with an answer as its content; text goes as it is, and so does a whole response."""
    if isinstance(answer, tuple):
        return answer
    return completion(answer if isinstance(answer, str) else json.dumps(answer))


@contextmanager
def speaking(*answers):
    """A model that gives the answers one after another, the last again and again; and its server."""
    bodies = [
        (lambda body, answer=answer: as_completion(answer(body))) if callable(answer) else as_completion(answer)
        for answer in answers
    ]
    with serving(*bodies) as (server, url):
        settings = OpenAISettings(
            base_url=url, model="test", api_key=KEY, attempts=1, input_price=1.0, output_price=2.0
        )
        yield RecordingModel(OpenAIModel(settings)), server
