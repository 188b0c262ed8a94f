"""Pairs the messages of one tick: they share one stamp."""

from collections import deque
from collections.abc import Collection
from typing import Any

REMEMBERED = 64  # ticks that were dropped, whose parts may still come


class TickPairing:
    """Collects messages by stamp until every expected part of a tick is there.

    When a tick is handed out, older ones that still lack a part are of no use any more and are dropped.
    """

    def __init__(self, *parts: str) -> None:
        self._parts = frozenset(parts)
        self._ticks: dict[int, dict[str, Any]] = {}
        self._arrival: dict[int, float] = {}
        self._dropped: deque[tuple[int, set[str]]] = deque(maxlen=REMEMBERED)  # and the parts that each had

    def add(self, stamp: int, part: str, message: Any, now: float) -> dict[str, Any] | None:
        """Add one part of the tick ``stamp`` [ns] at wall time ``now`` [s]; returns the tick when it is complete."""
        tick = self._ticks.get(stamp)
        if tick is None:
            tick = self._ticks[stamp] = {}
            self._arrival[stamp] = now
        tick[part] = message
        if not self._parts <= tick.keys():
            return None
        self._forget_until(stamp)
        return tick

    def expect(self, *parts: str) -> None:
        """From now on a tick is complete with these parts; those that wait are judged anew when their next part comes."""
        self._parts = frozenset(parts)

    def waiting(self) -> tuple[int, dict[str, Any], float] | None:
        """The newest incomplete tick: its stamp [ns], its parts, and the wall time [s] of its first part."""
        if not self._ticks:
            return None
        stamp = max(self._ticks)
        return stamp, self._ticks[stamp], self._arrival[stamp]

    def oldest(self) -> tuple[int, dict[str, Any], float] | None:
        """The oldest incomplete tick, as ``waiting``: ages are counted from it, since a newer one comes every time."""
        if not self._ticks:
            return None
        stamp = min(self._ticks)
        return stamp, self._ticks[stamp], self._arrival[stamp]

    def newest_with(self, parts: Collection[str]) -> tuple[int, dict[str, Any]] | None:
        """The newest incomplete tick that has all of these parts: its stamp [ns] and its parts."""
        stamps = [stamp for stamp, tick in self._ticks.items() if tick.keys() >= {*parts}]
        return (max(stamps), self._ticks[max(stamps)]) if stamps else None

    def give_up(self, stamp: int) -> None:
        """Drop a tick that will not be waited for, and all older ones."""
        self._forget_until(stamp)

    def comes_too_late(self, stamp: int, part: str) -> bool:
        """Whether a part is what a dropped tick had to do without; the same part once more is not, nor in another time."""
        for dropped, parts in self._dropped:
            if dropped == stamp and part not in parts:
                parts.add(part)
                return True
        return False

    def clear(self) -> None:
        """Drop everything, and begin in another time."""
        self._ticks.clear()
        self._arrival.clear()
        self._dropped.clear()

    def _forget_until(self, stamp: int) -> None:
        for old in [known for known in self._ticks if known <= stamp]:
            tick = self._ticks.pop(old)
            if not self._parts <= tick.keys():
                self._dropped.append((old, {*tick}))
            del self._arrival[old]
