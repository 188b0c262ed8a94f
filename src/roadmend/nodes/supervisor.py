"""Silence is death: ends the nodes that hang, so that they are restarted as those are that died, and keeps account."""

import time
from collections.abc import Callable, Sequence

from roadmend.core.errors import RoadmendError
from roadmend.nodes.children import Child

START_S = 120.0  # [s] for a node to come up, and for all of them to begin the drive: they may have to compile
FRESH_S = 30.0  # [s] the same of one node that has come up while the others drive
LOCKSTEP_SILENCE_S, REALTIME_SILENCE_S = 20.0, 5.0  # [s] without a sign of life after which a node is ended
_POLL_S = 0.02
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

    def end(self, children: Sequence[Child], is_hurried: Callable[[], bool] = lambda: False) -> None:
        """Tell processes to end when the drive is over, and keep who had ended by himself and who does not answer.

        However soon before the end somebody falls silent: to this he must answer, in as much time as he had before.

        Args:
            children: the processes.
            is_hurried: whether there is no more time for that; who is still there then is ended and not blamed.
        """
        self.faults += [
            f"{child.name} {child.hung or f'ended ({child.exit_code})'}, at the end"
            for child in children
            if child.exit_code is not None
        ]
        there = [child for child in children if child.exit_code is None]
        for child in there:
            child.interrupt()
        until = time.monotonic() + self._silence
        while any(child.exit_code is None for child in there) and time.monotonic() < until and not is_hurried():
            time.sleep(_POLL_S)
        why = "" if is_hurried() else f"hung: no sign of life for {self._silence:g} s"
        for child in there:
            if child.exit_code is None:
                child.kill(why)
        self.faults += [f"{child.name} {child.hung}, at the end" for child in there if child.hung]
