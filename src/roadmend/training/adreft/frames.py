"""A set of labelled frames in memory, and the batches that are drawn from it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.adreft.labels import FrameLabels
from roadmend.training.adreft.token_rows import TokenRows


@dataclass(frozen=True, slots=True, eq=False)
class FrameBatch:
    """B frames, padded to the N tokens of the largest."""

    tokens: NDArray[np.float32]  # shape (B, N, c), zero where padded
    mask: NDArray[np.bool_]  # shape (B, N), true where there is a token
    action: NDArray[np.float32]  # the policy's throttle - brake, shape (B,)
    critical: NDArray[np.float32]  # shape (B,)
    critical_weight: NDArray[np.float32]  # shape (B,)
    best: NDArray[np.int64]  # index into ACTIONS, shape (B,)
    best_weight: NDArray[np.float32]  # shape (B,)


@dataclass(frozen=True, slots=True, eq=False)
class FrameSet(TokenRows):
    """F labelled frames with their tokens, float32."""

    action: NDArray[np.float32]  # shape (F,), as are all below
    critical: NDArray[np.float32]
    critical_weight: NDArray[np.float32]
    best: NDArray[np.int64]
    best_weight: NDArray[np.float32]

    @classmethod
    def join(cls, frames: Sequence[CaseFrames], labels: Sequence[FrameLabels], attributes: int) -> Self:
        """All frames of some cases with their labels."""
        counts = np.concatenate([np.zeros(1, dtype=np.int64), *(entry.counts.astype(np.int64) for entry in frames)])
        empty = np.empty(0, dtype=np.float32)
        return cls(
            np.concatenate([np.empty((0, attributes), dtype=np.float32), *(entry.tokens for entry in frames)]),
            np.cumsum(counts),
            np.concatenate([empty, *(entry.action for entry in frames)]),
            np.concatenate([empty, *(entry.critical for entry in labels)]),
            np.concatenate([empty, *(entry.critical_weight for entry in labels)]),
            np.concatenate([np.empty(0, dtype=np.int64), *(entry.action for entry in labels)]),
            np.concatenate([empty, *(entry.action_weight for entry in labels)]),
        )

    @property
    def digest(self) -> str:
        """SHA-256 over all that is learned from, hexadecimal."""
        return self.digest_of()

    def batch(self, chosen: NDArray[np.int64]) -> FrameBatch:
        """Some frames as one batch, in the order chosen."""
        tokens, mask = self.padded(chosen)
        return FrameBatch(
            tokens,
            mask,
            self.action[chosen],
            self.critical[chosen],
            self.critical_weight[chosen],
            self.best[chosen],
            self.best_weight[chosen],
        )

    def draw(self, number: int, critical_share: float | None, generator: np.random.Generator) -> NDArray[np.int64]:
        """Indices of the frames of one epoch.

        Args:
            number: how many; without ``critical_share`` at most all of them, none twice.
            critical_share: share of frames with a critical label above 0.5; None: as they come.
            generator: source of chance.
        """
        if critical_share is None:
            order = generator.permutation(len(self))
            return order[:number]
        is_critical = self.critical > 0.5
        parts = []
        wanted = round(number * critical_share)
        for group, count in ((np.flatnonzero(is_critical), wanted), (np.flatnonzero(~is_critical), number - wanted)):
            if len(group):
                whole, rest = divmod(count, len(group))  # every frame as often as any other, give or take one
                parts += [np.repeat(group, whole), generator.permutation(group)[:rest]]
        return generator.permutation(np.concatenate(parts)) if parts else np.empty(0, dtype=np.int64)

    def batches(self, chosen: NDArray[np.int64], size: int, generator: np.random.Generator) -> Iterator[FrameBatch]:
        """Batches of ``size`` frames in random order; frames with like numbers of tokens meet, which saves padding."""
        return map(self.batch, self.batches_of(chosen, size, generator))

    def sorted_batches(self, size: int) -> Iterator[tuple[NDArray[np.int64], FrameBatch]]:
        """All frames once, by number of tokens, with their indices: for judging, where order does not matter."""
        return ((chosen, self.batch(chosen)) for chosen in self.sorted_batches_of(np.arange(len(self)), size))
