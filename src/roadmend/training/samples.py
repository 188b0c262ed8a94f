"""What a neural policy learns from: scenes with the expert's advice, in memory and on disk."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import opened_arrays
from roadmend.core.errors import InputError
from roadmend.core.whole_file import written_beside

UNASKED = -1  # label of the lane change where there is nothing to decide


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """T scenes with labels; the tokens of all scenes lie one after another."""

    tokens: NDArray[np.float16]  # (sum of counts, COLUMNS)
    counts: NDArray[np.int16]  # (T,)
    actions: NDArray[np.float32]  # (T,) the expert's, in [-1, 1]
    changes: NDArray[np.int8]  # (T,) whether it would begin the lane change: 0, 1 or UNASKED
    episodes: NDArray[np.int32]  # (T,) which episode a scene comes from
    outcomes: tuple[str, ...]  # of each episode

    @classmethod
    def join(cls, parts: "list[Samples]") -> "Samples":
        """All samples of several parts; episodes are numbered on."""
        begins = np.cumsum([0, *(len(part.outcomes) for part in parts[:-1])])
        return cls(
            np.concatenate([part.tokens for part in parts]),
            np.concatenate([part.counts for part in parts]),
            np.concatenate([part.actions for part in parts]),
            np.concatenate([part.changes for part in parts]),
            np.concatenate([part.episodes + begin for part, begin in zip(parts, begins, strict=True)]).astype(np.int32),
            tuple(outcome for part in parts for outcome in part.outcomes),
        )

    def __len__(self) -> int:
        return len(self.counts)


def samples_digest(samples: Samples) -> str:
    """SHA-256 of all samples, hexadecimal."""
    value = hashlib.sha256()
    for array in (samples.tokens, samples.counts, samples.actions, samples.changes, samples.episodes):
        value.update(np.ascontiguousarray(array).tobytes())
    return value.hexdigest()


def save_samples(path: Path, samples: Samples, made_by: str) -> None:
    """Write samples, whole or not at all, with the description of what made them."""
    with written_beside(path) as beside, beside.open("wb") as file:
        np.savez(
            file,
            tokens=samples.tokens,
            counts=samples.counts,
            actions=samples.actions,
            changes=samples.changes,
            episodes=samples.episodes,
            outcomes=np.array(samples.outcomes),
            made_by=np.array(made_by),
        )


def load_samples(path: Path, made_by: str) -> Samples:
    """Read samples.

    Raises:
        InputError: the file is damaged, or other settings made it.
    """
    mend = "give another folder, or delete this one"
    try:
        with opened_arrays(path) as file:
            if str(file["made_by"]) != made_by:
                raise InputError(str(path), "was made with other settings, or by other code", mend)
            return Samples(
                file["tokens"],
                file["counts"],
                file["actions"],
                file["changes"],
                file["episodes"],
                tuple(str(outcome) for outcome in file["outcomes"]),
            )
    except (OSError, ValueError) as error:
        raise InputError(str(path), f"cannot be read ({error})", mend) from None
