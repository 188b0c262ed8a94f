"""What is asked for so that all publishers match, and what becomes of topics that cannot be taken in."""

import pytest
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos import QoSCompatibility as Compatibility
from rclpy.qos import qos_check_compatible as compatibility
from std_msgs.msg import Float64

from roadmend.core.errors import InputError
from roadmend.nodes import discovery
from roadmend.nodes.discovery import LookUp, look_up, request_for

OFFERS = [
    QoSProfile(depth=depth, reliability=reliability, durability=durability)
    for depth in (1, 10)
    for reliability in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
    for durability in (DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL)
]


@pytest.mark.parametrize("depth", [None, 100])
@pytest.mark.parametrize("first", OFFERS)
@pytest.mark.parametrize("second", OFFERS)
def test_the_request_matches_every_offer(first, second, depth):
    request = request_for([first, second], depth)
    for offer in (first, second):
        verdict, why = compatibility(offer, request)
        assert verdict is not Compatibility.ERROR, why


def test_as_much_is_asked_for_as_all_offer():
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    assert request_for([latched, latched]).durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert request_for([latched]).reliability == ReliabilityPolicy.RELIABLE
    assert request_for([latched]).history == HistoryPolicy.KEEP_ALL
    bounded = request_for([latched], 7)
    assert (bounded.history, bounded.depth) == (HistoryPolicy.KEEP_LAST, 7)


def test_a_topic_has_a_definition_and_a_class():
    definition, kind = look_up("/gap", ["std_msgs/msg/Float64"])
    assert definition.type_name == "std_msgs/msg/Float64"
    assert kind is Float64


def test_what_cannot_be_taken_in_says_why(monkeypatch):
    with pytest.raises(
        InputError, match=r"^/x: has several types, a/msg/B and c/msg/D; publish one of them elsewhere$"
    ):
        look_up("/x", ["a/msg/B", "c/msg/D"])
    with pytest.raises(InputError, match="no such message type is installed"):
        look_up("/x", ["nowhere_msgs/msg/Nothing"])

    def fail(name):
        raise ImportError(name)

    monkeypatch.setattr(discovery.importlib, "import_module", fail)
    with pytest.raises(InputError, match=r"^/x: its type cannot be imported .*; install the package std_msgs$"):
        look_up("/x", ["std_msgs/msg/Float64"])


def test_a_topic_that_was_refused_is_looked_up_again_with_other_types():
    told = []
    topics = LookUp(told.append)
    several = ["std_msgs/msg/Float64", "std_msgs/msg/String"]
    assert topics.is_due("/odd", several)
    assert topics.find("/odd", several) is None
    assert "has several types" in topics.refused["/odd"]
    assert not topics.is_due("/odd", several)
    assert topics.is_due("/odd", several[:1])
    definition, _ = topics.find("/odd", several[:1])
    assert definition.type_name == several[0]
    assert (topics.refused, len(told)) == ({}, 1)
