"""The newest messages of each topic as bytes, found by the stamp of their tick, and when to draw."""

from collections import deque

from roadmend.recording.messages import NANOSECONDS, stamp_of_bytes


class TickMemory:
    """Keeps the last few messages of each topic undecoded.

    A thousand ticks a second may arrive while ten are drawn; the rest should cost no more than this.
    """

    def __init__(self, topics: tuple[str, ...], depth: int = 4) -> None:
        self._kept: dict[str, deque[tuple[int, bytes]]] = {topic: deque(maxlen=depth) for topic in topics}

    def put(self, topic: str, data: bytes) -> int:
        """Keep a message and return its stamp [ns].

        Raises:
            ValueError: the message has no header.
        """
        stamp = stamp_of_bytes(data)
        self._kept[topic].append((stamp, data))
        return stamp

    def at(self, topic: str, stamp: int) -> bytes | None:
        """The newest message of a topic with exactly this stamp [ns]."""
        return next((data for kept, data in reversed(self._kept[topic]) if kept == stamp), None)

    def newest(self, topic: str) -> int | None:
        """Stamp [ns] of the topic's newest message."""
        kept = self._kept[topic]
        return kept[-1][0] if kept else None

    def drop_after(self, stamp: int) -> None:
        """Forget messages of later ticks: time has run backwards to ``stamp`` [ns]."""
        for kept in self._kept.values():
            earlier = [entry for entry in kept if entry[0] <= stamp]
            kept.clear()
            kept.extend(earlier)


class Cadence:
    """Says which ticks to draw: the first at or after each multiple of the period, none twice.

    Args:
        rate: drawings a second of simulation time.
        load: share of one processor that drawing may take at most, in 0..1; where ticks come faster than that
            allows, some are left out.
    """

    def __init__(self, rate: float, load: float) -> None:
        self.set(rate, load)
        self._due = -(2**62)
        self._free_at = 0.0
        self.left_out = 0  # periods without a drawing so far

    def set(self, rate: float, load: float) -> None:
        """Change rate and load from the next tick on."""
        self._period = max(round(NANOSECONDS / rate), 1)
        self._load = load

    def is_due(self, stamp: int) -> bool:
        """Whether the tick with this stamp [ns] should be drawn as far as simulation time goes."""
        return stamp >= self._due

    def may_draw(self, now: float) -> bool:
        """Whether drawing at wall time ``now`` [s] stays under the load."""
        return now >= self._free_at

    def drawn(self, stamp: int, now: float, cost: float) -> None:
        """The tick with this stamp [ns] is drawn at wall time ``now`` [s], which took ``cost`` [s] of a processor."""
        slot = stamp // self._period
        if self._due >= 0:
            self.left_out += max(slot - self._due // self._period, 0)
        self._due = (slot + 1) * self._period
        self._free_at = now + cost * (1.0 / self._load - 1.0)

    def restart(self) -> None:
        """Draw the next tick, whatever its stamp."""
        self._due = -(2**62)
