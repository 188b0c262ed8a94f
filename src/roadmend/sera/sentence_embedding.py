"""Embeddings of descriptions in words, by a model for sentences: of an endpoint, or any callable in Python."""

import importlib
import json
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.json_text import parse_json
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.words import words_of, words_of_pattern

Encode = Callable[[Sequence[str]], Any]  # texts to vectors, shape (texts, dimensions)

# The vector of this text is kept in a bank: a model that gives another one is another model.
_PROBE = (
    "intersection with traffic light; the ego turns left; 2 car; car oncoming ignores the right of way; rain by day"
)
_SAME_FROM = 0.999  # cosine
_REMEDY = "use the embedder that the bank was made with, or build the bank again"


class SentenceEmbedder:
    """Puts descriptions into words and has a model encode them; words are all that it sees."""

    def __init__(self, name: str, open_encode: Callable[[], Encode], probe: NDArray[np.float32]) -> None:
        """Wrap a model.

        Args:
            name: by which it is found again.
            open_encode: opens the model when it is first needed.
            probe: vector of a fixed text by that model, shape (dimensions,).
        """
        self.name = name
        self.probe = probe
        self._open = open_encode

    @classmethod
    def begin(cls, name: str, encode: Encode) -> Self:
        """For a new bank.

        Raises:
            InputError: what the model gives are no vectors.
        """
        return cls(name, lambda: encode, _encoded(name, encode, [_PROBE])[0])

    @property
    def dimensions(self) -> int:
        """Length of a vector."""
        return len(self.probe)

    def embed(self, items: Sequence[Descriptor | FailurePattern]) -> NDArray[np.float32]:
        """Vectors of length 1, shape (items, dimensions); zero where there are no words.

        Raises:
            InputError: the model cannot be used, or is not the one that the bank was made with.
            LanguageError: the endpoint of the model does not answer.
        """
        texts = [words_of(item) if isinstance(item, Descriptor) else words_of_pattern(item) for item in items]
        said = [row for row, text in enumerate(texts) if text.strip()]
        result = np.zeros((len(texts), self.dimensions), dtype=np.float32)
        if said:
            vectors = _encoded(self.name, self._encode, [texts[row] for row in said])
            self._check(vectors.shape[1] == self.dimensions)
            result[said] = vectors
        return result

    @cached_property
    def _encode(self) -> Encode:
        """The model, once it has shown that it is the one the bank was made with."""
        encode = self._open()
        found = _encoded(self.name, encode, [_PROBE])[0]
        self._check(len(found) == self.dimensions and float(found @ self.probe) >= _SAME_FROM)
        return encode

    def _check(self, is_same: bool) -> None:  # noqa: FBT001 - reads as an assertion
        if not is_same:
            raise InputError(f"embedder {self.name}", "gives other vectors than those in the bank", _REMEDY)

    def dump(self) -> bytes:
        """The probe's vector."""
        return json.dumps({"probe": self.probe.tolist()}).encode()

    @classmethod
    def load(cls, name: str, open_encode: Callable[[], Encode], content: bytes) -> Self:
        """From what ``dump`` gave; the model is not opened yet.

        Raises:
            ValueError: the content is damaged.
        """
        try:
            probe = np.array(parse_json(content, "probe")["probe"], dtype=np.float32)
        except (InputError, KeyError, TypeError) as error:
            raise ValueError(str(error)) from None
        return cls(name, open_encode, probe)


def open_endpoint(model: str) -> tuple[str, Encode]:
    """The full name of an endpoint's model and its encoder; the environment says where it is, no bank does.

    Args:
        model: its name; that of the settings if empty.

    Raises:
        InputError: the settings are unusable, or there is no key.
    """
    # Its client takes a second to import, and most runs do without.
    from roadmend.language.openai_embedding import OpenAIEmbedding  # noqa: PLC0415

    endpoint = OpenAIEmbedding.open(model)
    return f"openai:{endpoint.model}", endpoint.encode


def open_python(path: str, *, is_trusted: bool) -> Encode:
    """A callable by its import path, ``module:name``, where the name may have dots.

    Args:
        path: to import.
        is_trusted: whether the user has named it; what a bank alone names is not run.

    Raises:
        InputError: it is not trusted, or cannot be imported.
    """
    where = f"embedder python:{path}"
    if not is_trusted:
        raise InputError(
            where,
            "is code that the bank was made with, and not run on a bank's word",
            f"give --embedder python:{path} if you trust it",
        )
    module, _, name = path.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except Exception as error:  # noqa: BLE001 - foreign code
        problem = f"cannot be imported ({type(error).__name__}: {error})"
        raise InputError(where, problem, "give python:MODULE:CALLABLE, with the module on PYTHONPATH") from None
    if not callable(found):
        raise InputError(where, "cannot be called", "give a callable that takes texts and gives vectors")
    encode: Encode = found
    return encode


def _encoded(name: str, encode: Encode, texts: Sequence[str]) -> NDArray[np.float32]:
    """Vectors of length 1, shape (texts, dimensions)."""
    remedy = "give a model that turns n texts into n vectors"
    try:
        vectors = np.asarray(encode(texts), dtype=np.float32)
    except RoadmendError:
        raise
    except Exception as error:  # noqa: BLE001 - foreign code
        raise InputError(f"embedder {name}", f"failed ({type(error).__name__}: {error})", remedy) from None
    if vectors.ndim != 2 or len(vectors) != len(texts) or not vectors.shape[1]:
        raise InputError(f"embedder {name}", f"gives the shape {vectors.shape} for {len(texts)} texts", remedy)
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    if not np.isfinite(vectors).all() or not lengths.all():
        raise InputError(f"embedder {name}", "gives vectors that are zero or not finite", remedy)
    return np.asarray(vectors / lengths)
