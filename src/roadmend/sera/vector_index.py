"""Nearest vectors by inner product: exact where they are few, by scanning 4-bit codes and then exactly where many.

Product-quantised codes of half a byte (Jegou et al. 2011; the fast scan of faiss) put a vector into a quarter of a byte
a dimension, so that a million are looked through in milliseconds; the best thousand are then ranked by the vectors
themselves, which are kept in half precision. Cells that skip most of the vectors do not help here: a failure pattern
speaks of few things, and what agrees with it is scattered over all cells.
"""

from dataclasses import dataclass
from typing import Any, Self

import faiss
import numpy as np
from numpy.typing import NDArray

EXACT_UP_TO = 5_000  # vectors that are compared one by one
_CANDIDATES = 1000  # ranked exactly
_SEED = 1
_TRAINED_ON = 100_000  # vectors
_CHUNK = 50_000  # vectors at a time

Halves = NDArray[np.float16]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class VectorIndex:
    """Vectors of length 1 and, where there are many, the codes that they are found by.

    Searching uses one thread: a bank serves next to other work.
    """

    vectors: Halves  # shape (n, dimensions)
    codes: Any  # faiss index, None for an exact one

    @classmethod
    def build(cls, vectors: Halves) -> Self:
        """Train the codes on a sample and add all; the same vectors give the same index.

        Args:
            vectors: shape (n, dimensions), may be a memory map.
        """
        count = len(vectors)
        if count <= EXACT_UP_TO:
            return cls(vectors, None)
        dimensions = vectors.shape[1] + vectors.shape[1] % 2
        # One cell: of the two kinds of fast scan, only the one with cells takes filters.
        scan = faiss.IndexIVFPQFastScan(
            faiss.IndexFlatIP(dimensions), dimensions, 1, dimensions // 2, 4, faiss.METRIC_INNER_PRODUCT
        )
        scan.by_residual = False
        scan.cp.seed = scan.pq.cp.seed = _SEED
        # Turned at random, every pair of dimensions carries as much as any other; of 400,000 generated scenarios, the
        # best thousand by code then hold all of the ten best, where without it they hold 96 %.
        rotation = faiss.RandomRotationMatrix(vectors.shape[1], dimensions)
        rotation.init(_SEED)
        codes = faiss.IndexPreTransform(rotation, scan)
        with _one_thread():
            codes.train(_wide(vectors[:: max(1, count // _TRAINED_ON)]))
            for start in range(0, count, _CHUNK):
                codes.add(_wide(vectors[start : start + _CHUNK]))
        return cls(vectors, codes)

    def search(
        self, query: NDArray[np.float32], count: int, allowed: Mask | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """The ``count`` nearest: their numbers and inner products, best first, ties by number.

        Args:
            query: of length 1, shape (dimensions,).
            count: at most so many are returned.
            allowed: those that may be returned, shape (n,); None for all.
        """
        places = self._candidates(query, count, allowed)
        scores = self.vectors[places].astype(np.float32) @ query if places is not None else self._all_scores(query)
        numbers = places if places is not None else np.arange(len(self.vectors))
        order = np.lexsort((numbers, -scores))[:count]
        return numbers[order].astype(np.int64), scores[order]

    def _candidates(self, query: NDArray[np.float32], count: int, allowed: Mask | None) -> NDArray[np.int64] | None:
        if allowed is not None and (self.codes is None or np.count_nonzero(allowed) <= EXACT_UP_TO):
            return np.flatnonzero(allowed)
        if self.codes is None:
            return None
        selector = None
        if allowed is not None:
            selector = faiss.IDSelectorBitmap(np.packbits(allowed, bitorder="little"))
        within = faiss.SearchParametersIVF(nprobe=1, sel=selector)
        parameters = faiss.SearchParametersPreTransform(index_params=within)
        with _one_thread():
            _, found = self.codes.search(_wide(query[None]), max(_CANDIDATES, 4 * count), params=parameters)
        places: NDArray[np.int64] = found[0][found[0] >= 0]
        return places

    def _all_scores(self, query: NDArray[np.float32]) -> NDArray[np.float32]:
        return self.vectors.astype(np.float32) @ query

    def dump_codes(self) -> NDArray[np.uint8]:
        """The codes as bytes; none for an exact index."""
        if self.codes is None:
            return np.zeros(0, dtype=np.uint8)
        content: NDArray[np.uint8] = faiss.serialize_index(self.codes)
        return content

    @classmethod
    def load(cls, vectors: Halves, codes: NDArray[np.uint8]) -> Self:
        """From what was stored; whoever stored it vouches for the bytes."""
        return cls(vectors, faiss.deserialize_index(codes) if codes.size else None)

    @property
    def size(self) -> int:
        """Bytes in memory, codes and vectors."""
        return int(self.dump_codes().size + self.vectors.nbytes)


class _one_thread:  # noqa: N801 - reads as a statement
    """faiss on one thread, whatever the rest of the process has chosen."""

    def __enter__(self) -> None:
        self._before = faiss.omp_get_max_threads()
        faiss.omp_set_num_threads(1)

    def __exit__(self, *_: object) -> None:
        faiss.omp_set_num_threads(self._before)


def _wide(vectors: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    """As faiss takes them: in single precision, row by row."""
    return np.ascontiguousarray(vectors, dtype=np.float32)
