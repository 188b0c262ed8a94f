"""The embedding that needs no network and no downloaded weights: latent semantic analysis, trained on the bank itself.

Terms are weighted by TF-IDF and projected on the leading singular directions of the bank (Deerwester et al. 1990).
Quantities that are ordered, a speed or a share, follow as points on a quarter of a circle each: the inner product of
two falls with their difference, and one that is unknown is the centre, which agrees with all alike.
"""

import io
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import opened_arrays
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.terms import RANGES, Features, features

_DIRECTIONS = 112  # of the latent space; with two a quantity, 128 dimensions
_TERMS_MOST = 4096  # of the vocabulary
_SHARE_OF_TERMS = 0.75  # of an inner product; the quantities have the rest
# How much a group of terms counts: place, hazard, conditions and the outcome more than who else was there. Others count 1.
_FACTORS = {
    "outcome": 1.5,
    "road": 1.5,
    "hazard": 1.5,
    "weather": 1.5,
    "light": 2.0,
    "hazard+participant": 0.7,
    "hazard+side": 0.7,
    "participant": 0.3,
    "driver": 0.3,
}
_CHUNK = 2048  # descriptions at a time
_PLACES = {name: place for place, name in enumerate(RANGES)}


@dataclass(frozen=True)
class LatentEmbedder:
    """A vocabulary with its weights, and the directions that terms are projected on."""

    vocabulary: Mapping[str, int]  # term -> row of the projection
    weights: NDArray[np.float64]  # inverse document frequency times the group's factor, shape (terms,)
    projection: NDArray[np.float64]  # shape (terms, directions)

    name = "latent"

    @property
    def dimensions(self) -> int:
        """Length of a vector."""
        return int(self.projection.shape[1]) + 2 * len(RANGES)

    def embed(self, items: Sequence[Descriptor | FailurePattern]) -> NDArray[np.float32]:
        """Vectors of length 1, shape (items, dimensions); zero for what has no known term."""
        result = np.empty((len(items), self.dimensions), dtype=np.float32)
        for start in range(0, len(items), _CHUNK):
            chunk = [features(item) for item in items[start : start + _CHUNK]]
            result[start : start + len(chunk)] = self._embed(chunk)
        return result

    def _embed(self, items: Sequence[Features]) -> NDArray[np.float64]:
        terms = _unit(_weighted(items, self.vocabulary, self.weights) @ self.projection)
        quantities = _unit(_arcs(items)) * terms.any(axis=1, keepdims=True)
        return _unit(np.hstack([math.sqrt(_SHARE_OF_TERMS) * terms, math.sqrt(1.0 - _SHARE_OF_TERMS) * quantities]))

    def dump(self) -> bytes:
        """Vocabulary, weights and projection as an .npz file."""
        names = np.frombuffer(json.dumps([*self.vocabulary]).encode(), dtype=np.uint8)
        stream = io.BytesIO()
        np.savez(stream, vocabulary=names, weights=self.weights, projection=self.projection)
        return stream.getvalue()

    @classmethod
    def load(cls, content: bytes) -> Self:
        """From what ``dump`` gave.

        Raises:
            ValueError: the content is damaged.
        """
        try:
            with opened_arrays(io.BytesIO(content)) as arrays:
                names = parse_json(arrays["vocabulary"].tobytes(), "vocabulary")
                return cls({name: row for row, name in enumerate(names)}, arrays["weights"], arrays["projection"])
        except (OSError, InputError) as error:
            raise ValueError(str(error)) from None


def fit_latent(descriptors: Iterable[Descriptor]) -> LatentEmbedder:
    """Learn vocabulary, weights and directions; the same descriptors in the same order give the same embedder."""
    documents = [features(descriptor) for descriptor in descriptors]
    counts = Counter(term for document in documents for term in document.terms)
    # Common terms first: a rare word may go, what a bank is made of may not.
    names = sorted(counts, key=lambda term: (-counts[term], term))[:_TERMS_MOST]
    vocabulary = {name: row for row, name in enumerate(names)}
    frequency = np.array([counts[name] for name in names], dtype=np.float64)
    factors = np.array([_FACTORS.get(name.partition(":")[0], 1.0) for name in names])
    weights = factors * (np.log((1.0 + len(documents)) / (1.0 + frequency)) + 1.0)
    gram = np.zeros((len(names), len(names)))
    for start in range(0, len(documents), _CHUNK):
        rows = _unit(_weighted(documents[start : start + _CHUNK], vocabulary, weights))
        gram += rows.T @ rows
    return LatentEmbedder(vocabulary, weights, _leading_directions(gram))


def _leading_directions(gram: NDArray[np.float64]) -> NDArray[np.float64]:
    """Right singular vectors of the rows behind a Gram matrix, by falling singular value; signs are fixed."""
    _, vectors = np.linalg.eigh(gram)
    leading = vectors[:, ::-1][:, :_DIRECTIONS]
    if leading.size:
        leading = leading * np.sign(leading[np.abs(leading).argmax(axis=0), np.arange(leading.shape[1])])
    return np.ascontiguousarray(leading)


def _weighted(
    items: Sequence[Features], vocabulary: Mapping[str, int], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """TF-IDF rows, shape (items, terms); the frequency of a term counts by its logarithm."""
    found = [
        (row, vocabulary[term], count)
        for row, item in enumerate(items)
        for term, count in item.terms.items()
        if term in vocabulary
    ]
    result = np.zeros((len(items), len(vocabulary)))
    if found:
        rows, columns, counts = np.array(found).T
        result[rows, columns] = (1.0 + np.log(counts)) * weights[columns]
    return result


def _arcs(items: Sequence[Features]) -> NDArray[np.float64]:
    """Quantities as points on quarter circles, shape (items, 2 x quantities)."""
    result = np.zeros((len(items), 2 * len(RANGES)))
    for row, item in enumerate(items):
        for name, value in item.quantities.items():
            low, high = RANGES[name]
            angle = 0.5 * math.pi * min(max((value - low) / (high - low), 0.0), 1.0)
            place = 2 * _PLACES[name]
            result[row, place : place + 2] = math.cos(angle), math.sin(angle)
    return result


def _unit(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of length 1; those of length 0 stay."""
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    return rows / np.where(lengths > 0.0, lengths, 1.0)
