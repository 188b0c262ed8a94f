"""One writer a command topic: whose messages are obeyed, where a stranger publishes on it as well.

ROS tells a reader neither who wrote a message nor by which endpoint it came. It tells who publishes on the topic, and
the number that each message has among those of its writer. The numbers of the writer that was obeyed go on where they
were; what does not fit them is not obeyed. In doubt nobody is, and the vehicle brakes. That is order, no
authentication: against a node that means harm only SROS 2 helps.
"""

from collections.abc import Callable, Sequence

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from roadmend.nodes.inputs import Input
from roadmend.nodes.numbered_input import NumberedInput
from roadmend.nodes.policy_watch import PERIOD_S

FIRST = 50  # highest number of a message that may be the first of a writer, while a stranger is there
NEAR = 3  # numbers of two that lie no farther apart do not tell who speaks
HEARD = 1.0  # [s] for which a stranger that has spoken is reckoned with as the next to speak
GAP = 10  # messages of one writer that may be lost in a row
LOST_PER_S = 250.0  # and so many more for each second since the last one


class WriterGate:
    """Tells what is obeyed.

    Args:
        writer: name of the node that is obeyed, without its namespace; empty for whoever was there alone first, and once
            that one has gone for who comes then and is alone.
    """

    def __init__(self, writer: str = "") -> None:
        self.writer = writer
        self._is_given = bool(writer)
        self._former = {writer}  # short names of those who have been the writer
        self._beside: set[str] = set()  # full names of those who have been strangers beside it
        self.refused = 0  # messages
        self.strangers: tuple[str, ...] = ()  # full names of those who publish as well
        self._is_there = False
        self._last: int | None = None  # number of the last message that was obeyed
        self._last_at = 0.0  # [s]
        self._skipped: int | None = None  # number that would have followed the one before that
        self._other: int | None = None  # of the last one that was refused
        self._other_at = 0.0  # [s]
        self._is_sure = False  # whether its numbers were beyond those that another one begins with when it was alone
        self._is_doubtful = False  # two speak whose numbers do not tell them apart
        self._known = 0  # endpoints of the writer that were seen at once

    def see(self, publishers: Sequence[str]) -> None:
        """Take in who publishes on the topic now: full names, one for each publisher, empty where it is not yet told."""
        names = {*publishers}
        mine = self._mine(publishers)
        if not self._is_given and not mine and len(names) == 1 and "" not in names:
            alone = next(iter(names))
            short = alone.rpartition("/")[2]
            # Who was a stranger beside the writer stays one; but a writer of before has its place again.
            if not self.writer or short in self._former or alone not in self._beside:
                self.writer = short
                self._former.add(short)
                mine = self._mine(publishers)
        if len(mine) > self._known:  # it was started anew, and so were its numbers
            self._last, self._skipped, self._is_sure, self._is_doubtful = None, None, False, False
        self._known, self._is_there = len(mine), bool(mine)
        self.strangers = tuple(sorted(names - {*mine}))
        if mine:
            self._beside |= {*self.strangers}
        self._is_doubtful = self._is_doubtful and bool(self.strangers)

    def _mine(self, publishers: Sequence[str]) -> list[str]:
        return [name for name in publishers if name and name.rpartition("/")[2] == self.writer]

    def admits(self, number: int, now: float) -> bool:
        """Whether the message with this number, which came at wall time ``now`` [s], is obeyed."""
        if not self.strangers:
            self._is_sure = number > FIRST
            self._take(number, now)
            self._other = self._skipped = None
            return True
        if not self._is_sure and self._last is not None and number <= self._last:
            self._is_doubtful = True
        if number == self._skipped and not self._is_near(number, now):
            self._is_doubtful = True  # who was obeyed has skipped nothing: that was the stranger
        if self._is_there and not self._is_doubtful and self._is_next(number, now):
            self._take(number, now)
            return True
        # Of two that pass each other it is the stranger who is ahead thereafter: one that is as slow is never told apart.
        self._other = number if self._other is None or not self._is_near(number, now) else max(number, self._other)
        self._other_at = now
        self.refused += 1
        return False

    def _is_near(self, number: int, now: float) -> bool:
        """Whether a number is so near to the stranger's that it may be its own."""
        return self._other is not None and now - self._other_at < HEARD and abs(number - self._other) <= NEAR

    def _is_next(self, number: int, now: float) -> bool:
        if self._is_near(number, now):
            return False
        if self._last is None:
            return number <= FIRST
        return 0 < number - self._last <= GAP + LOST_PER_S * (now - self._last_at)

    def _take(self, number: int, now: float) -> None:
        self._skipped = None if self._last is None or number <= self._last + 1 else self._last + 1
        self._last, self._last_at = number, now


class GatedInput:
    """A command topic's subscription behind a gate; ``take`` gets the messages that are obeyed.

    Who publishes is looked up when the number of publishers changes, when a message's number does not follow the last one,
    since another may have taken the writer's place, and now and then once somebody has spoken; not for each message.

    Args:
        node: who listens.
        wanted: the topic.
        kind: the class of its messages.
        writer: see ``WriterGate``.
        take: called with the bytes of each message.
        clock: tells the wall time [s].
    """

    def __init__(
        self,
        node: Node,
        wanted: Input,
        kind: type,
        writer: str,
        take: Callable[[bytes], None],
        clock: Callable[[], float],
    ) -> None:
        self.gate = WriterGate(writer)
        self._node, self._wanted, self._take, self._clock = node, wanted, take, clock
        self._count = -1
        self._number = 0  # of the last message, whoever's
        self._named: tuple[str, ...] = ()
        self._input = NumberedInput(node, wanted, kind, self._on_message)
        node.create_timer(PERIOD_S, self._look_again, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _look(self) -> None:
        self._count, before = self._input.publishers, self.gate.writer
        self.gate.see(self._wanted.endpoints(self._node))
        if before and self.gate.writer != before:
            self._node.get_logger().warning(f"{self._wanted.topic}: {self.gate.writer} takes the place of {before}")

    def _look_again(self) -> None:
        """A stranger's numbers may happen to follow; but before anybody has spoken nobody is the writer yet."""
        if self._count >= 0:
            self._look()

    def _on_message(self, data: bytes, number: int) -> None:
        # One that stays the same is of a middleware that does not tell; and of two who speak none follows the other's, so
        # that it says nothing where a stranger is known.
        is_odd = number not in (self._number, self._number + 1) and not self.gate.strangers
        self._number = number
        if self._input.publishers != self._count or is_odd or "" in self.gate.strangers:
            self._look()
        if self.gate.admits(number, self._clock()):
            self._take(data)
            return
        if self.gate.strangers != self._named and "" not in self.gate.strangers:
            self._named = self.gate.strangers
            self._node.get_logger().warning(self.warning)

    @property
    def warning(self) -> str:
        """Who else publishes, for people; empty where nobody does."""
        others = ", ".join(filter(None, self.gate.strangers))
        if not others or not self.gate.refused:
            return ""
        return f"{self._wanted.topic}: {others} publishes too, and is not obeyed; only {self.gate.writer or 'one'} is"
