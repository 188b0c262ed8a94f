"""Any endpoint that speaks OpenAI's protocol for embeddings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import openai
from numpy.typing import NDArray

from roadmend.core.bounds import TEXT
from roadmend.language.chat import AnswerError
from roadmend.language.openai_chat import OpenAISettings, clear_errors, client_of, read_openai_settings

_AT_ONCE = 256  # texts in one request


@dataclass(frozen=True)
class OpenAIEmbedding:
    """A model of an endpoint that turns texts into vectors."""

    settings: OpenAISettings
    model: str
    client: openai.OpenAI

    @classmethod
    def open(cls, model: str = "") -> Self:
        """The endpoint of the environment.

        Args:
            model: that of the settings if empty.

        Raises:
            InputError: the settings are unusable, or there is no key.
        """
        settings = read_openai_settings(None)
        return cls(settings, model or settings.embedding_model, client_of(settings, TEXT))

    def encode(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Vectors, shape (texts, dimensions).

        Raises:
            UnavailableError: no answer, as often as it was tried.
            AnswerError: what came is not one vector a text.
        """
        rows: list[Any] = []
        for start in range(0, len(texts), _AT_ONCE):
            rows += self._encode(texts[start : start + _AT_ONCE])
        return np.array(rows, dtype=np.float32)

    def _encode(self, texts: Sequence[str]) -> list[Any]:
        with clear_errors(self.settings, "no embeddings"):
            answer = self.client.embeddings.create(model=self.model, input=[*texts], encoding_format="float")
        try:
            found = sorted(getattr(answer, "data", None) or [], key=lambda each: each.index)
            vectors = np.array([each.embedding for each in found], dtype=np.float32)
            is_whole = vectors.ndim == 2 and [each.index for each in found] == [*range(len(texts))]
        except (AttributeError, TypeError, ValueError):  # of no such shape at all
            is_whole = False
        if not is_whole:
            raise AnswerError(f"{self.settings.place} did not send one vector for each of {len(texts)} texts")
        return [*vectors]
