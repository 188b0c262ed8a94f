"""Hold and release: an intervention lasts a while and ends for good, instead of flapping with every tick."""

from dataclasses import replace

from roadmend.core.repair import Proposal

_TICK = 1e-6  # [s] slack against rounding in sums of ticks


class Latch:
    """Remembers an intervention until it may be left.

    It begins with a proposal above its threshold and is left as soon as it is at least ``hold`` seconds old and no
    such proposal has come for ``clear`` seconds. Until then the last action stays. Time is simulation time.
    """

    def __init__(self, hold: float, clear: float) -> None:
        self._hold = hold  # [s]
        self._clear = clear  # [s]
        self._since = 0.0
        self._clear_since: float | None = None
        self._last: Proposal | None = None

    @property
    def is_on(self) -> bool:
        """Whether an intervention is under way."""
        return self._last is not None

    def reset(self) -> None:
        """Forget the intervention."""
        self._last = None
        self._clear_since = None

    def settle(self, time: float, proposal: Proposal) -> Proposal:
        """What to propose at ``time`` [s] when the scene alone calls for ``proposal``."""
        if proposal.score > proposal.threshold:
            if self._last is None:
                self._since = time
            self._last = proposal
            self._clear_since = None
            return proposal
        last = self._last
        if last is None:
            return proposal
        if self._clear_since is None:
            self._clear_since = time
        held, clear = time - self._since + _TICK, time - self._clear_since + _TICK
        if held >= self._hold and clear >= self._clear:
            self.reset()
            return proposal
        return replace(last, reason=f"held {held:.2f} s, clear for {clear:.2f} s; before: {last.reason}")
