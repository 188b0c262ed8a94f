"""Each message type of ours survives serialization, whole and empty."""

import array
import importlib
from pathlib import Path

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message

REPOSITORY = Path(__file__).parents[2]
NAMES = sorted(path.stem for path in (REPOSITORY / "msg" / "msg").glob("*.msg"))
ACTIONS = sorted(path.stem for path in (REPOSITORY / "msg" / "action").glob("*.action"))
SERVICES = sorted(path.stem for path in (REPOSITORY / "msg" / "srv").glob("*.srv"))
VALUES = {
    "boolean": True,
    "double": 0.1 + 0.2,
    "float": 0.5,
    "string": "Übergang → 道路",
    "int8": -(2**7),
    "uint8": 2**8 - 1,
    "int16": -(2**15),
    "uint16": 2**16 - 1,
    "int32": -(2**31),
    "uint32": 2**32 - 1,
    "int64": -(2**63),
    "uint64": 2**64 - 1,
}


def load(package, name):
    return getattr(importlib.import_module(package + ".msg"), name)


def filled(message_type):
    """A message with an extreme value in every field, and three of them in every sequence."""
    message = message_type()
    for field, kind in message_type.get_fields_and_field_types().items():
        element = kind.removeprefix("sequence<").removesuffix(">")
        value = VALUES[element] if element in VALUES else filled(load(*element.split("/")))
        setattr(message, field, [value] * 3 if kind.startswith("sequence<") else value)
    return message


def test_there_are_messages():
    assert "ObjectList" in NAMES
    assert "BuildCrashScenarios" in ACTIONS


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("make", [filled, lambda message_type: message_type()], ids=["filled", "empty"])
def test_round_trip(name, make):
    message = make(load("roadmend_msgs", name))
    assert deserialize_message(serialize_message(message), type(message)) == message


@pytest.mark.parametrize("name", ACTIONS)
@pytest.mark.parametrize("part", ["Goal", "Result", "Feedback"])
def test_actions_make_the_round_trip(name, part):
    message = filled(getattr(getattr(importlib.import_module("roadmend_msgs.action"), name), part))
    assert deserialize_message(serialize_message(message), type(message)) == message


@pytest.mark.parametrize("name", SERVICES)
@pytest.mark.parametrize("half", ["Request", "Response"])
def test_both_halves_of_a_service_survive(name, half):
    message_type = getattr(getattr(importlib.import_module("roadmend_msgs.srv"), name), half)
    for message in (filled(message_type), message_type()):
        assert deserialize_message(serialize_message(message), message_type) == message


def test_transforms_can_be_sent():
    message = filled(load("geometry_msgs", "TransformStamped"))
    message = load("tf2_msgs", "TFMessage")(transforms=[message, message])
    assert deserialize_message(serialize_message(message), type(message)) == message


def test_number_sequences_are_flat_buffers():
    """The hot path rests on this: a sequence of numbers is one block of memory, whatever its length."""
    objects = load("roadmend_msgs", "ObjectList")(x=array.array("d", range(1000)))
    received = deserialize_message(serialize_message(objects), type(objects))
    assert isinstance(received.x, array.array)
    np.testing.assert_array_equal(np.frombuffer(received.x), np.arange(1000.0))


def test_a_float_keeps_what_is_not_a_number():
    state = load("roadmend_msgs", "RepairState")(score=float("nan"), threshold=float("inf"))
    received = deserialize_message(serialize_message(state), type(state))
    assert np.isnan(received.score)
    assert received.threshold == float("inf")
