"""Silence is death: ends the nodes that hang, so that they are restarted as those are that died, and keeps account."""

from collections.abc import Sequence

from roadmend.core.errors import RoadmendError
from roadmend.nodes.children import Child

START_S = 120.0  # [s] for a node to come up, and for all of them to begin the drive: they may have to compile
FRESH_S = 30.0  # [s] the same of one node that has come up while the others drive
LOCKSTEP_SILENCE_S, REALTIME_SILENCE_S = 20.0, 5.0  # [s] without a sign of life after which a node is ended
RESTARTS_MAX = 5  # of one node in one run


class Supervisor:
    """Looks after node processes; who calls it restarts them, or not.

    Args:
        silence: wall time without a sign of life [s] after which a node that drives counts as dead.
        start: the same [s] before the drive has begun.
    """

    def __init__(self, silence: float, start: float = START_S) -> None:
        self.faults: list[str] = []  # who ended or hung, in one line each
        self._silence, self._start = silence, max(start, silence)

    def end_silent(self, children: Sequence[Child], now: float, *, is_driving: bool) -> None:
        """End, at wall time ``now`` [s], the processes that have given no sign of life for too long."""
        for child in children:
            if child.exit_code is not None or child.process is None:
                continue
            child.pulse.look(now)
            fresh = max(self._silence, FRESH_S)
            limit = self._start if not is_driving else self._silence if child.pulse.is_settled else fresh
            if child.pulse.silence > limit:
                child.kill(f"hung: no sign of life for {limit:g} s")

    def restart(self, child: Child) -> str:
        """Start a process again that has ended, and return a line about it for people.

        Raises:
            RoadmendError: it has ended too often.
        """
        how = child.hung or f"ended ({child.exit_code})"
        if child.restarts >= RESTARTS_MAX:
            raise RoadmendError(f"{child.name} ended {RESTARTS_MAX + 1} times; last: {child.fault()}")
        child.restarts += 1
        self.faults.append(f"{child.name} {how}, restarted")
        child.start()
        return self.faults[-1]

    def still_silent(self, children: Sequence[Child]) -> list[str]:
        """Those that have given no sign of life for so long that a hang is likely, in one line each."""
        return [
            f"{child.name} hung: no sign of life for {child.pulse.silence:.0f} s, to the end"
            for child in children
            if child.exit_code is None and child.pulse.silence > 0.5 * self._silence
        ]
