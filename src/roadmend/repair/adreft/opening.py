"""Full braking with which an intervention begins, whatever the adapter holds to be enough."""

from roadmend.repair.actions import ACTIONS

_TICK = 1e-6  # [s] slack against rounding in sums of ticks


class Opening:
    """Replaces the choices of an intervention's first moments by the strongest.

    Speed that is taken off early counts until the impact, while brakes take a moment to bite: the least that repairs a
    violation is one short pulse of full command well ahead, not a milder one that lasts.

    Args:
        seconds: [s] for which, 0: not at all.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._since: float | None = None  # [s]

    def reset(self) -> None:
        """Forget the intervention."""
        self._since = None

    def action(self, time: float, chosen: float, *, is_due: bool) -> float:
        """What to propose at ``time`` [s].

        Args:
            time: of the tick.
            chosen: the adapter's throttle - brake.
            is_due: whether an intervention is under way.
        """
        if not is_due:
            self._since = None
            return chosen
        if self._since is None:
            self._since = time
        return ACTIONS[-1] if time - self._since + _TICK < self._seconds else chosen
