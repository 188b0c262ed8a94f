"""Decisions of a policy that are learned from, and the batches that are drawn of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.training.adreft.token_rows import TokenRows

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class DecisionBatch:
    """B decisions, padded to the N tokens of the largest."""

    tokens: Floats  # shape (B, N, c), zero where padded
    mask: NDArray[np.bool_]  # shape (B, N), true where there is a token
    action: Floats  # the policy's throttle - brake, shape (B,)


@dataclass(frozen=True, slots=True, eq=False)
class DecisionSet(TokenRows):
    """F decisions with their tokens, float16, and what the monitor should say of them."""

    action: Floats  # the policy's throttle - brake, shape (F,), as are all below
    critical: Floats  # 0 safe .. 1 critical
    judged: Floats  # weight of that label, 0 where it says nothing

    @property
    def digest(self) -> str:
        """SHA-256 over all that is learned from, hexadecimal."""
        return self.digest_of()

    def batch(self, chosen: NDArray[np.int64]) -> DecisionBatch:
        """Some decisions as one batch, in the order chosen."""
        tokens, mask = self.padded(chosen)
        return DecisionBatch(tokens, mask, self.action[chosen])

    def draw(self, number: int, generator: np.random.Generator) -> NDArray[np.int64]:
        """Indices of ``number`` decisions in random order, none twice; 0 stands for all."""
        order = generator.permutation(len(self))
        return order[:number] if number else order
