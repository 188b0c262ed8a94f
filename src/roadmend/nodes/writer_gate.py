"""One writer a command topic: whose messages are obeyed, where a stranger publishes on it as well.

ROS tells a reader neither who wrote a message nor by which endpoint it came. It tells who publishes on the topic, and
the number that each message has among those of its writer. The numbers of the writer that was obeyed go on where they
were; what does not fit them is not obeyed. In doubt nobody is, and the vehicle brakes. That is order, no
authentication: against a node that means harm only SROS 2 helps.
"""

from collections.abc import Callable, Sequence

from rclpy.node import Node

from roadmend.nodes.inputs import Input
from roadmend.nodes.numbered_input import NumberedInput

FIRST = 50  # highest number of a message that may be the first of a writer, while a stranger is there
GAP = 10  # messages of one writer that may be lost in a row
LOST_PER_S = 250.0  # and so many more for each second since the last one


class WriterGate:
    """Tells what is obeyed.

    Args:
        writer: name of the node that is obeyed, without its namespace; empty for whoever was there alone first.
    """

    def __init__(self, writer: str = "") -> None:
        self.writer = writer
        self.refused = 0  # messages
        self.strangers: tuple[str, ...] = ()  # full names of those who publish as well
        self._is_there = False
        self._last: int | None = None  # number of the last message that was obeyed
        self._last_at = 0.0  # [s]
        self._other: int | None = None  # of the last one that was refused
        self._is_sure = False  # whether its numbers were beyond those that another one begins with when it was alone
        self._is_doubtful = False  # two speak whose numbers do not tell them apart
        self._known = 0  # endpoints of the writer that were seen at once

    def see(self, publishers: Sequence[str]) -> None:
        """Take in who publishes on the topic now: full names, one for each publisher, empty where it is not yet told."""
        names = {*publishers}
        if not self.writer and len(names) == 1 and "" not in names:
            self.writer = next(iter(names)).rpartition("/")[2]
        mine = [name for name in publishers if name and name.rpartition("/")[2] == self.writer]
        if len(mine) > self._known:  # it was started anew, and so were its numbers
            self._last, self._is_sure, self._is_doubtful = None, False, False
        self._known, self._is_there = len(mine), bool(mine)
        self.strangers = tuple(sorted(names - {*mine}))
        self._is_doubtful = self._is_doubtful and bool(self.strangers)

    def admits(self, number: int, now: float) -> bool:
        """Whether the message with this number, which came at wall time ``now`` [s], is obeyed."""
        if not self.strangers:
            self._is_sure = number > FIRST
            self._take(number, now)
            return True
        if not self._is_sure and self._last is not None and number <= self._last:
            self._is_doubtful = True
        if self._is_there and not self._is_doubtful and self._is_next(number, now):
            self._take(number, now)
            return True
        self._other = number
        self.refused += 1
        return False

    def _is_next(self, number: int, now: float) -> bool:
        if self._other is not None and number == self._other + 1:
            return False  # it goes on where the stranger was
        if self._last is None:
            return number <= FIRST
        return 0 < number - self._last <= GAP + LOST_PER_S * (now - self._last_at)

    def _take(self, number: int, now: float) -> None:
        self._last, self._last_at = number, now


class GatedInput:
    """A command topic's subscription behind a gate; ``take`` gets the messages that are obeyed.

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
        self._named: tuple[str, ...] = ()
        self._input = NumberedInput(node, wanted, kind, self._on_message)

    def _on_message(self, data: bytes, number: int) -> None:
        count = self._input.publishers
        if count != self._count or "" in self.gate.strangers:
            self._count = count
            self.gate.see(self._wanted.endpoints(self._node))
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
