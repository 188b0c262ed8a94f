"""Embeddings: descriptors and patterns as vectors of one space, by whichever model is chosen."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.latent import fit_latent, load_latent
from roadmend.sera.pattern import FailurePattern

Vectors = NDArray[np.float32]


class Embedder(Protocol):
    """Turns descriptions into vectors. What it has learned from a bank is kept in the bank."""

    @property
    def dimensions(self) -> int:
        """Length of a vector."""

    def embed(self, items: Sequence[Descriptor | FailurePattern]) -> Vectors:
        """Vectors of length 1, shape (items, dimensions); zero for what means nothing to the model."""

    def dump(self) -> bytes:
        """What it takes to embed again."""


@dataclass(frozen=True)
class EmbedderKind:
    """How an embedder is trained on a bank and read back from one."""

    fit: Callable[[Iterable[Descriptor]], Embedder]
    load: Callable[[bytes], Embedder]


EMBEDDERS: Mapping[str, EmbedderKind] = {"latent": EmbedderKind(fit_latent, load_latent)}


def embedder_kind(name: str) -> EmbedderKind:
    """The kind of embedder of a name.

    Raises:
        InputError: there is none.
    """
    if name not in EMBEDDERS:
        raise InputError("embedder", f"there is no {name!r}", f"choose one of {', '.join(EMBEDDERS)}")
    return EMBEDDERS[name]
