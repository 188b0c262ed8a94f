"""Messages at the start of a further file of a bag that stand in an earlier one too, so that it can be played alone."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

_MASK = 0xFFFFFFFF  # numbers have 32 bits in a file


@dataclass(frozen=True, slots=True)
class Repeats:
    """Those of one topic in one file, told apart from messages that came late and lie behind them.

    Attributes:
        time_ns: their log time [ns], that at which the file began; None of a bag of before, which tells their number alone.
        sequences: their numbers.
    """

    time_ns: int | None
    sequences: Sequence[int]

    def __len__(self) -> int:
        return len(self.sequences)

    def __str__(self) -> str:
        return " ".join(map(str, (self.time_ns, *self.sequences)))

    @classmethod
    def parse(cls, text: str) -> Self:
        """From the text of a bag's metadata.

        Raises:
            ValueError: it is none.
        """
        first, *others = map(int, text.split(" "))
        if others:
            return cls(first, tuple(others))
        if not 0 <= first <= _MASK:
            raise ValueError(f"{first} repeated messages")
        return cls(None, range(first))

    def taker(self) -> Callable[[int, int], bool]:
        """A function of log time and number that tells whether a message is one of them; it takes none twice."""
        left = Counter({0: len(self)}) if self.time_ns is None else Counter(each & _MASK for each in self.sequences)

        def take(time_ns: int, sequence: int) -> bool:
            number = 0 if self.time_ns is None else sequence & _MASK
            if self.time_ns not in {None, time_ns} or not left[number]:
                return False
            left[number] -= 1
            return True

        return take
