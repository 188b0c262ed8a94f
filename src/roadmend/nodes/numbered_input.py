"""A subscription that tells the number of each message among those of its writer, under every executor.

In this build of rclpy the events executor, which the graph needs for its speed, fails over a callback that asks for the
message's account. A waitable takes the message by itself. What a waitable raises ends the process with a segmentation
fault there; what a timer raises comes out of the executor, as of any other callback.
"""

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.waitable import NumberOfEntities, Waitable

from roadmend.nodes.inputs import Input


class NumberedInput(Waitable):
    """Listens to one topic.

    Args:
        node: who listens.
        wanted: the topic.
        kind: the class of its messages.
        take: called with the bytes of each message and its number, 0 where the middleware does not tell.
    """

    def __init__(self, node: Node, wanted: Input, kind: type, take: Callable[[bytes, int], None]) -> None:
        super().__init__(node.default_callback_group)
        self._node, self._take, self._is_due, self._index = node, take, False, 0
        self._subscription = node.create_subscription(kind, wanted.topic, lambda _: None, wanted.request, raw=True)
        # No executor shall take its messages but through this.
        node._subscriptions.remove(self._subscription)  # noqa: SLF001 - rclpy has no other way
        node.add_waitable(self)

    @property
    def publishers(self) -> int:
        """How many publishers match now."""
        return int(self._subscription.get_publisher_count())

    def is_ready(self, wait_set: Any) -> bool:
        """For the executor."""
        self._is_due = bool(wait_set.is_ready("subscription", self._index))
        return self._is_due

    def take_data(self) -> Any:
        """For the executor."""
        if not self._is_due:
            return None
        self._is_due = False
        with self._subscription.handle:
            return self._subscription.handle.take_message(self._subscription.msg_type, True)

    async def execute(self, taken_data: Any) -> None:
        """For the executor."""
        if taken_data is None:
            return
        try:
            self._take(taken_data[0], taken_data[1]["publication_sequence_number"] or 0)
        except Exception as error:  # noqa: BLE001 - whatever it is, it is raised again
            self._raise_later(error)

    def _raise_later(self, error: Exception) -> None:
        def fail() -> None:
            raise error

        # Of a steady clock: the node's own may stand still.
        self._node.create_timer(0.0, fail, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def get_num_entities(self) -> NumberOfEntities:
        """For the executor."""
        return NumberOfEntities(num_subs=1)

    def add_to_wait_set(self, wait_set: Any) -> None:
        """For the executor."""
        with self._subscription.handle:
            self._index = wait_set.add_subscription(self._subscription.handle)
