"""How often and how long a method held lane changes back, and the same without looking: what waiting does by itself."""

import random
from dataclasses import dataclass, field
from typing import Self


@dataclass
class Waits:
    """Requests for lane changes in one episode. One is uninterrupted asking; it ends as soon as it is granted."""

    requests: int = 0
    lengths: list[int] = field(default_factory=list)  # [ticks] for which those that were held back at all waited
    _asked: bool = False

    def watch(self, *, asks: bool, held: bool) -> None:
        """Take in one tick."""
        begins = asks and not self._asked
        self.requests += begins
        if asks and held:
            if begins:
                self.lengths.append(0)
            self.lengths[-1] += 1
        self._asked = asks and held

    def player(self, seed: str) -> "WaitPlayer":
        """Holds back as often and as long, whatever the scene."""
        return WaitPlayer(self, random.Random(seed))


class WaitPlayer:
    """Holds a request back with the chance that a method did, for one of the times that it did."""

    def __init__(self, waits: Waits, chance: random.Random) -> None:
        self._waits, self._chance = waits, chance
        self._asked, self._left = False, 0

    @classmethod
    def idle(cls) -> Self:
        """One that holds nothing back."""
        return cls(Waits(), random.Random(0))

    def holds(self, *, asks: bool) -> bool:
        """Whether a request of this tick waits."""
        if not asks:
            self._asked = False
            return False
        if not self._asked:
            lengths = self._waits.lengths
            is_held = bool(lengths) and self._chance.random() < len(lengths) / self._waits.requests
            self._left = self._chance.choice(lengths) if is_held else 0
        self._left -= 1
        self._asked = self._left >= 0
        return self._asked
