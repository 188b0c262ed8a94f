"""The publishers of a replay: one for each recorded topic whose type is installed."""

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy

from roadmend.core.errors import InputError
from roadmend.nodes.discovery import look_up
from roadmend.nodes.qos import profile_of
from roadmend.recording.reader import BagReader, Record
from roadmend.recording.replay import check_definition, offer_of
from roadmend.recording.topics import CLOCK


class Players:
    """Publish recorded bytes with the recorded offers.

    Args:
        node: whose publishers they are.
        reader: the bag.
        topics: the topics to play; those that cannot be are named in ``skipped``.

    Raises:
        InputError: none can be played.
    """

    def __init__(self, node: Node, reader: BagReader, topics: Sequence[str]) -> None:
        self.publishers: dict[str, Publisher] = {}
        self.skipped: dict[str, str] = {}  # topic and why
        self.count = 0  # messages so far
        self._node = node
        self._bag = str(reader.path)
        for name in topics:
            topic = reader.topics[name]
            try:
                check_definition(reader, name)
                _, kind = look_up(name, [topic.type_name])
            except InputError as error:
                self.skipped[name] = str(error)
                node.get_logger().warning(f"not played: {error}")
                continue
            # Relative, so that the topics follow the node's namespace; the clock is one for all.
            target = name if name == CLOCK else name.lstrip("/")
            profile = profile_of(offer_of(topic.offers, topic.count))
            self.publishers[name] = node.create_publisher(kind, target, profile)
        if not self.publishers:
            raise InputError(str(reader.path), "no topic can be played", next(iter(self.skipped.values())))

    def play(self, records: Sequence[Record]) -> None:
        """Publish messages; those of other topics are left out.

        Raises:
            InputError: one is not what its topic holds.
        """
        for record in records:
            publisher = self.publishers.get(record.topic)
            if publisher is not None:
                try:
                    publisher.publish(record.data)
                except RuntimeError:  # RCLError: for DDS they are more bytes than the type can have
                    what = f"a message on {record.topic} is not a {record.type_name}"
                    raise InputError(self._bag, what, "take another bag") from None
                self.count += 1

    def repeat(self, records: Sequence[Record]) -> None:
        """Publish messages again, except what late joiners get anyway."""
        for record in records:
            publisher = self.publishers.get(record.topic)
            if publisher is not None and publisher.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL:
                publisher.publish(record.data)

    def subscriptions(self) -> int:
        """How many subscriptions listen, over all topics."""
        return sum(publisher.get_subscription_count() for publisher in self.publishers.values())

    def unheard(self) -> list[str]:
        """Topics that nobody listens to."""
        return [name for name, publisher in self.publishers.items() if not publisher.get_subscription_count()]

    def listeners(self) -> set[str]:
        """Names of the nodes that listen to any topic."""
        return {
            info.node_name
            for publisher in self.publishers.values()
            for info in self._node.get_subscriptions_info_by_topic(publisher.topic_name)
        }
