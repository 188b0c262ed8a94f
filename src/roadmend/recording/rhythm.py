"""How regularly messages come."""

import math
from collections import Counter
from dataclasses import dataclass, field

_GAP = 2.5  # times the usual interval, from which on a silence is a gap
_STEADY = 1.5  # the upper quartile of the intervals over their median, up to which a topic has a rate to keep
_STEADY_COUNT = 10  # messages below which nothing is said about that
_BINS = 20.0  # of the intervals' histogram, for each factor of e
_SECOND = 1e9


@dataclass(slots=True)
class Rhythm:
    """When the messages of one topic came, in memory that does not grow with their number."""

    count: int = 0
    first_ns: int = 0
    last_ns: int = 0  # of the latest that came
    end_ns: int = 0
    back: int = 0  # messages that are older than the one before
    longest_ns: int = 0  # the longest silence
    longest_at_ns: int = 0  # and when it began
    _intervals: Counter[int] = field(default_factory=Counter)  # rising ones, in logarithmic bins

    def add(self, time_ns: int) -> None:
        """Count one message."""
        self.count += 1
        if self.count == 1:
            self.first_ns = self.last_ns = self.end_ns = time_ns
            return
        interval = time_ns - self.last_ns
        if interval < 0:
            self.back += 1
        elif interval > 0:
            self._intervals[round(math.log(interval) * _BINS)] += 1
            if interval > self.longest_ns:
                self.longest_ns, self.longest_at_ns = interval, self.last_ns
        self.first_ns = min(self.first_ns, time_ns)
        self.end_ns = max(self.end_ns, time_ns)
        self.last_ns = time_ns

    @property
    def rate(self) -> float | None:
        """Messages a second; None where they all have one time."""
        span = self.end_ns - self.first_ns
        return (self.count - 1) / span * _SECOND if span > 0 else None

    @property
    def gaps(self) -> int | None:
        """Silences much longer than the usual interval; None for topics that keep no rate."""
        usual = self._quantile(0.5)
        if self.count < _STEADY_COUNT or not usual or self._quantile(0.75) > _STEADY * usual:
            return None
        return sum(count for place, count in self._intervals.items() if math.exp(place / _BINS) > _GAP * usual)

    def _quantile(self, share: float) -> float:
        left = share * self._intervals.total()
        for place, count in sorted(self._intervals.items()):
            left -= count
            if left <= 0:
                return math.exp(place / _BINS)
        return 0.0
