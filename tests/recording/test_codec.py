"""Messages to bytes and back, read by readers that are strict about the length."""

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.recording.codec import MessageType, encode, type_of
from roadmend.recording.reader import BagReader


def test_every_kind_of_message_comes_out_as_it_went_in(corpus):
    for record in (reader := BagReader(corpus[0])).records():
        message = reader.decode(record)
        assert type_of(message) == record.type_name
        assert encode(message) == record.data


def test_what_rclpy_reads_is_what_was_said_and_no_byte_is_behind_its_end(make):
    from rclpy.serialization import deserialize_message, serialize_message
    from roadmend_msgs.msg import Route

    kind = MessageType("roadmend_msgs/msg/Route")
    given = {"x": np.array([1.0, 2.0]), "zone_rule": np.array([2], np.uint8), "zone_signal": np.array([-1], np.int32)}
    data = encode(kind(scenario="crossing", **given))
    make("roadmend_msgs/msg/Route")  # registers the type
    assert list(make.store.deserialize_cdr(data, "roadmend_msgs/msg/Route").x) == [1.0, 2.0]
    route = deserialize_message(data, Route)
    assert (route.scenario, route.zone_signal.tolist(), route.goal) == ("crossing", [-1], 0.0)
    assert len(data) <= len(serialize_message(route))
    assert kind.decode(serialize_message(route)).x.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    "name", ["nav_msgs/msg/Odometry", "visualization_msgs/msg/Marker", "roadmend_msgs/msg/FailurePattern"]
)
def test_what_is_not_said_is_zero_empty_or_false(name):
    kind = MessageType(name)
    data = encode(kind())
    assert not any(data[4:].replace(b"\x01", b"\x00"))  # an empty text has a length of 1
    assert encode(kind.decode(data)) == data


def test_numbers_of_another_type_are_refused():
    with pytest.raises(ValueError, match=r"(?s)."):
        encode(MessageType("roadmend_msgs/msg/ObjectList")(id=np.arange(3, dtype=np.int64)))


def test_a_field_that_the_type_does_not_have_is_refused():
    with pytest.raises(TypeError, match="colour"):
        MessageType("std_msgs/msg/Float64")(colour=1)


def test_a_type_that_is_not_installed_is_named():
    with pytest.raises(InputError, match="absent_msgs/None: no such message type is installed"):
        MessageType("absent_msgs/msg/None")()
