"""Rows of tokens of different lengths, one after another in one array, and the batches that are cut from them."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

_POOL = 16  # batches whose rows are sorted by length together

Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class TokenRows:
    """F rows; row f has the tokens ``tokens[offsets[f] : offsets[f + 1]]``."""

    tokens: NDArray[Any]  # of floating point, shape (M, c)
    offsets: Indices  # shape (F + 1,)

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def sizes(self) -> Indices:
        """Tokens of each row, shape (F,)."""
        return np.diff(self.offsets)

    def digest_of(self, *left_out: str) -> str:
        """SHA-256 over all fields but some, hexadecimal."""
        value = hashlib.sha256()
        for field in fields(self):
            if field.name not in left_out:
                array = getattr(self, field.name)
                value.update(f"{array.dtype.str}{array.shape}".encode())
                value.update(np.ascontiguousarray(array).tobytes())
        return value.hexdigest()

    def padded(self, chosen: Indices) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Tokens of B rows in the order chosen, padded with zeros to the N of the longest.

        Returns:
            Tokens, shape (B, N, c), and a mask that is true where there is one, shape (B, N).
        """
        starts, sizes = self.offsets[chosen], self.sizes[chosen]
        places = np.arange(max(1, int(sizes.max(initial=0))))[None, :]
        mask = places < sizes[:, None]
        tokens = np.zeros((*mask.shape, self.tokens.shape[1]), dtype=np.float32)
        tokens[mask] = self.tokens[(starts[:, None] + places)[mask]]
        return tokens, mask

    def batches_of(self, chosen: Indices, size: int, generator: np.random.Generator) -> Iterator[Indices]:
        """Batches of ``size`` of the rows chosen, in random order; rows of like lengths meet, which saves padding."""
        cuts = [
            batch
            for start in range(0, len(chosen), _POOL * size)
            for batch in self.sorted_batches_of(chosen[start : start + _POOL * size], size)
        ]
        for index in generator.permutation(len(cuts)):
            yield cuts[index]

    def sorted_batches_of(self, chosen: Indices, size: int) -> Iterator[Indices]:
        """Batches of ``size`` of the rows chosen, by length: for judging, where order does not matter."""
        order = chosen[np.argsort(self.sizes[chosen], kind="stable")]
        for start in range(0, len(order), size):
            yield order[start : start + size]
