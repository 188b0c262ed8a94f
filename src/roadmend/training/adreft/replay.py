"""The replay memory of the DQN: the last so many transitions, as arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.training.adreft.exploring import Transitions

_FIELDS = ("state", "action", "reward", "discount", "after")


class ReplayMemory:
    """Forgets the oldest when it is full. The encoder is frozen, so states are kept instead of scenes."""

    def __init__(self, capacity: int, hidden: int) -> None:
        self._arrays: dict[str, NDArray[Any]] = {
            "state": np.zeros((capacity, hidden), dtype=np.float32),
            "action": np.zeros(capacity, dtype=np.int64),
            "reward": np.zeros(capacity, dtype=np.float32),
            "discount": np.zeros(capacity, dtype=np.float32),
            "after": np.zeros((capacity, hidden), dtype=np.float32),
        }
        self._capacity = capacity
        self.added = 0  # transitions ever added

    def __len__(self) -> int:
        return min(self.added, self._capacity)

    def add(self, transitions: Transitions) -> None:
        """Remember transitions; of more than fit, the last ones."""
        count = len(transitions)
        kept = min(count, self._capacity)
        places = (self.added + count - kept + np.arange(kept)) % self._capacity
        for name, array in self._arrays.items():
            array[places] = getattr(transitions, name)[count - kept :]
        self.added += count

    def sample(self, size: int, generator: np.random.Generator) -> Transitions:
        """Draw uniformly with replacement."""
        chosen = generator.integers(len(self), size=size)
        return Transitions(*(self._arrays[name][chosen] for name in _FIELDS))

    def tensors(self, prefix: str) -> dict[str, NDArray[Any]]:
        """All that is remembered, by name."""
        return {f"{prefix}{name}": array[: len(self)] for name, array in self._arrays.items()}

    def load(self, tensors: dict[str, NDArray[Any]], prefix: str, added: int) -> None:
        """Remember again what ``tensors`` gave."""
        self.added = added
        for name, array in self._arrays.items():
            array[: len(self)] = tensors[f"{prefix}{name}"]
