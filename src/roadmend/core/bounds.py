"""How much a file from outside may ask of this machine: the one table of limits that every reader goes by.

A limit stands well above what people, or this project itself, write, and low enough that the worst file below it is
read or refused within 10 s and 512 MB. What a limit refuses is refused with one line, an ``InputError``.
"""

from dataclasses import dataclass

from roadmend.core.errors import InputError


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits of one kind of file; a reader looks at those that its format has."""

    size: int = 16_000_000  # [bytes] of the file as it lies on the disk
    unpacked: int = 64_000_000  # [bytes] that it may become where it is compressed
    ratio: float = 100.0  # of these bytes to those on the disk
    free: int = 16_000_000  # [bytes] that may be unpacked without a look at the ratio
    line: int = 4_000_000  # [characters] of a line, where every line is a value by itself
    depth: int = 64  # of lists in lists, or of elements in elements
    values: int = 200_000  # scalars, lists and mappings, or elements; one that is referred to counts every time
    digits: int = 300  # of one number; the largest double has 309

    def check_size(self, where: str, size: int) -> None:
        """Refuse a file that is too large.

        Args:
            where: the file.
            size: its own [bytes].

        Raises:
            InputError: it is larger than ``size``.
        """
        if size > self.size:
            what = f"is {size / 1e6:.0f} MB large, at most {self.size / 1e6:.0f} are read"
            raise InputError(where, what, "give another file")

    def room(self, packed: int) -> int:
        """How many bytes may come out of so many compressed ones."""
        return min(self.unpacked, max(self.free, int(self.ratio * packed)))


SETTINGS = Bounds()
"""What people write by hand: scenarios, parameters, configurations, plans (YAML, JSON)."""

CRASH = Bounds(size=1_000_000, values=20_000)
"""A crash scenario of ``safe``: one accident, of which every line is remembered for the messages."""

TEXT = Bounds(size=64_000_000)
"""A text of lines that is held in memory: a corpus, exchanges with a language model, a selection."""

REPLY = Bounds(size=8_000_000)
"""What an endpoint answers to one request of a language model; a long answer has some ten thousand characters."""

STREAM = Bounds(size=1 << 40)
"""A text that is read line by line and never held: an exported bank of a million scenarios."""

ARGUMENT = Bounds(size=64_000, values=10_000, depth=16)
"""A value on the command line, or within a record of a bag."""

NETWORK = Bounds(size=96_000_000, unpacked=96_000_000, values=500_000)
"""A SUMO network, its traffic or configuration (XML, as it is or compressed by gzip)."""

MODEL = Bounds(size=96_000_000, line=16_000_000)
"""A model (safetensors); ``line`` is its header."""

SKETCH = Bounds(size=20_000_000, values=25_000_000)
"""The picture of a crash; ``values`` are its pixels."""

BAG = Bounds(size=1 << 40, unpacked=1 << 40, free=1 << 30, ratio=1000.0, line=1 << 26)
"""A file of a bag (MCAP), read piece by piece; ``line`` is a piece: a record, or a chunk before compression [bytes].

Bags of driving have a ratio of 5, their best chunks one of 11; pictures of a covered camera one of thousands, so that a
gigabyte may come of anything: that takes less than a second, and never more memory than a piece."""

ARRAYS = Bounds(size=1 << 30, unpacked=1 << 30)
"""Arrays that this project has put on the disk itself (.npz), and arrays within a bank."""


class Allowance:
    """What may still come out of one file while it is read: its own size, many times over.

    Args:
        where: the file.
        packed: its size [bytes].
        bounds: of its kind.
    """

    def __init__(self, where: str, packed: int, bounds: Bounds) -> None:
        self._where = where
        self._left = self._room = bounds.room(packed)

    def take(self, count: int) -> None:
        """Ask for room before something is read or unpacked.

        Args:
            count: how much it takes [bytes].

        Raises:
            InputError: there is no room left.
        """
        self._left -= count
        if self._left < 0:
            what = f"holds more than {self._room / 1e6:.0f} MB where it is unpacked, which no recording does"
            raise InputError(self._where, what, "take another file")
