"""The time contract of the command path: how old an unanswered tick may become before somebody acts, in ticks.

Real time has one clock, the ticks: whatever the rate, the repair node answers a tick without its command when LATE_TICKS
newer ones are due, and the simulator obeys no command older than OBEYED_TICKS. Ages are counted from the oldest tick
without an answer, so that the next tick, which comes every time, makes nobody patient again. The repair node's limit
is the lower one: the simulator's watchdog has something to do only where the repair node itself is silent.

In lockstep simulation time stands still until the answer is there, so that there the limits are wall time.
"""

from dataclasses import dataclass

from roadmend.core.tick import INTERVAL, INTERVAL_NS

LATE_TICKS = 2  # real time: age at which a tick is answered without what it lacks
OBEYED_TICKS = 3  # real time: age of the oldest command that the simulator obeys
PROMPT_S, PROMPT_TICKS = 0.04, 0.8  # real time: patience with the parts of a tick, the longer of the two
LOCKSTEP_PATIENCE_S = 2.0  # [s] lockstep: the same
LOCKSTEP_IMPATIENCE_S = 0.02  # [s] lockstep: the same while somebody is known to be silent
PERIOD_S = 0.01  # [s] longest time between two looks at the ages


def age_of(stamp: int, newest: int) -> int:
    """How many ticks lie between the tick ``stamp`` [ns] and the newest one [ns]; negative for one yet to come."""
    return newest // INTERVAL_NS - stamp // INTERVAL_NS


def is_obeyed(age: int) -> bool:
    """Whether the simulator still obeys a command, in real time, that is so many ticks old."""
    return age <= OBEYED_TICKS


@dataclass(frozen=True, slots=True)
class CommandAge:
    """What the contract comes to for the repair node.

    Attributes:
        is_lockstep: whether the simulator waits for each answer.
        rate: real time: simulated seconds per wall second.
        timeout: wall time [s] that was asked for in place of the patience below; 0 for none. In real time it can only
            shorten what LATE_TICKS allows.
    """

    is_lockstep: bool
    rate: float = 1.0
    timeout: float = 0.0

    @property
    def tick(self) -> float:
        """Wall time between two ticks in real time [s]."""
        return INTERVAL / self.rate

    @property
    def patience(self) -> float:
        """Wall time [s] after the first part of the oldest unanswered tick, at which that tick is late."""
        if self.is_lockstep:
            return self.timeout or LOCKSTEP_PATIENCE_S
        return min(self.timeout or max(PROMPT_S, PROMPT_TICKS * self.tick), LATE_TICKS * self.tick)

    @property
    def impatience(self) -> float:
        """The same [s] while what is missing has been missing before."""
        return LOCKSTEP_IMPATIENCE_S if self.is_lockstep else min(self.patience, 0.5 * self.tick)

    @property
    def silence(self) -> float:
        """Real time: wall time [s] without any tick at which the stop begins that silence means."""
        return LATE_TICKS * self.tick

    @property
    def period(self) -> float:
        """Wall time between two looks [s]: often enough at every rate."""
        return PERIOD_S if self.is_lockstep else min(PERIOD_S, 0.25 * self.tick)

    def is_late(self, waited: float, age: int, *, is_silent: bool) -> bool:
        """Whether the oldest unanswered tick is to be answered without what it lacks.

        Args:
            waited: wall time since its first part came [s].
            age: of the tick, see ``age_of``.
            is_silent: whether the last answer had to do without, too.
        """
        if waited >= (self.impatience if is_silent else self.patience):
            return True
        return not self.is_lockstep and age >= LATE_TICKS
