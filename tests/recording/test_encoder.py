"""Messages to bytes: of rclpy and decoded ones, read back by readers that are strict about the length."""

from array import array

import pytest

from roadmend.core.errors import InputError
from roadmend.recording.encoder import Encoder
from roadmend.recording.reader import BagReader


def test_every_kind_of_message_comes_out_as_it_went_in(corpus):
    encoder = Encoder()
    for record in (reader := BagReader(corpus[0])).records():
        assert encoder.encode(record.type_name, reader.decode(record)) == record.data


def test_a_message_of_rclpy_has_no_bytes_behind_its_end(make):
    from rclpy.serialization import deserialize_message, serialize_message
    from roadmend_msgs.msg import Route

    route = Route(
        scenario="crossing", x=array("d", [1.0, 2.0]), zone_rule=array("B", [2]), zone_signal=array("i", [-1])
    )
    data = Encoder().encode("roadmend_msgs/msg/Route", route)
    make("roadmend_msgs/msg/Route")  # registers the type
    assert list(make.store.deserialize_cdr(data, "roadmend_msgs/msg/Route").x) == [1.0, 2.0]
    assert deserialize_message(data, Route) == route
    assert len(data) <= len(serialize_message(route))


def test_a_type_that_is_not_installed_is_named():
    with pytest.raises(InputError, match="absent_msgs/None: no such message type is installed"):
        Encoder().encode("absent_msgs/msg/None", None)
