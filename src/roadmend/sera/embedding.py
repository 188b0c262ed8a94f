"""Embeddings: descriptors and patterns as vectors of one space, by whichever model is chosen.

A model goes by a name, ``kind`` or ``kind:argument``: ``latent``; ``openai:MODEL``; ``python:module:callable``.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.latent import LatentEmbedder, fit_latent
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.sentence_embedding import SentenceEmbedder, open_endpoint, open_python

Vectors = NDArray[np.float32]
DEFAULT = "latent"


class Embedder(Protocol):
    """Turns descriptions into vectors. What it has learned from a bank is kept in the bank."""

    @property
    def name(self) -> str:
        """By which it is found again, with its argument."""

    @property
    def dimensions(self) -> int:
        """Length of a vector."""

    def embed(self, items: Sequence[Descriptor | FailurePattern]) -> Vectors:
        """Vectors of length 1, shape (items, dimensions); zero for what means nothing to the model.

        Raises:
            InputError: the model cannot be used, or is not the one that the bank was made with.
            LanguageError: the endpoint of the model does not answer.
        """

    def dump(self) -> bytes:
        """What it takes to embed again."""


@dataclass(frozen=True)
class _Kind:
    """How embedders of a kind come from their argument and a bank's descriptors, and from what was dumped.

    ``load`` is also told whether the user has named the embedder, or the bank alone has.
    """

    fit: Callable[[str, Iterable[Descriptor]], Embedder]
    load: Callable[[str, bytes, bool], Embedder]
    is_named: bool = False  # has an argument


_KINDS: Mapping[str, _Kind] = {
    "latent": _Kind(lambda _, items: fit_latent(items), lambda _, content, __: LatentEmbedder.load(content)),
    "openai": _Kind(
        lambda model, _: SentenceEmbedder.begin(*open_endpoint(model)),
        lambda model, content, _: SentenceEmbedder.load(f"openai:{model}", lambda: open_endpoint(model)[1], content),
        is_named=True,
    ),
    "python": _Kind(
        lambda path, _: SentenceEmbedder.begin(f"python:{path}", open_python(path, is_trusted=True)),
        lambda path, content, trusted: SentenceEmbedder.load(
            f"python:{path}", lambda: open_python(path, is_trusted=trusted), content
        ),
        is_named=True,
    ),
}
FORMS = "latent, openai[:MODEL], python:MODULE:CALLABLE"


def fit_embedder(name: str, descriptors: Iterable[Descriptor]) -> Embedder:
    """The embedder of a name, trained on descriptors where it learns.

    Raises:
        InputError: there is none, or it cannot be used.
        LanguageError: its endpoint does not answer.
    """
    kind, argument = _kind(name)
    return kind.fit(argument, descriptors)


def load_embedder(stored: str, content: bytes, named: str | None) -> Embedder:
    """The embedder that a bank was made with.

    Args:
        stored: its name, as the bank tells it.
        content: what was dumped.
        named: the name that the user expects, or None.

    Raises:
        InputError: it is another than the user expects, or there is none of its kind.
        ValueError: the content is damaged.
    """
    if named is not None and named not in {stored, stored.partition(":")[0]}:
        raise InputError(
            "embedder",
            f"the bank was made with {stored!r}, and vectors of {named!r} do not mix with its own",
            "leave the choice to the bank, or import it into a new one with the other embedder",
        )
    kind, argument = _kind(stored)
    return kind.load(argument, content, named == stored)


def inherited_embedder(stored: str) -> str:
    """The name of a bank's embedder, for a bank that is made from it.

    Raises:
        InputError: it is code, which is not run on a bank's word.
    """
    head, _, argument = stored.partition(":")
    if head == "python":
        open_python(argument, is_trusted=False)
    return stored


def check_embedder(name: str) -> None:
    """Refuse a name early.

    Raises:
        InputError: there is no such embedder.
    """
    _kind(name)


def _kind(name: str) -> tuple[_Kind, str]:
    head, _, argument = name.partition(":")
    if head not in _KINDS or (argument and not _KINDS[head].is_named):
        raise InputError("embedder", f"there is no {name!r}", f"choose one of {FORMS}")
    return _KINDS[head], argument
