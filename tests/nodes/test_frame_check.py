"""The frame that a message names is read off its bytes, whatever they are."""

import pytest

from roadmend.nodes.frame_check import FrameCheck, frame_of
from roadmend.recording import messages
from roadmend.recording.codec import encode


def command(frame):
    return encode(messages.COMMAND(header=messages.HEADER(frame_id=frame)))


@pytest.mark.parametrize("frame", ["", "map", "odom", "earth/näher"])
def test_the_frame_is_the_messages(frame):
    assert frame_of(command(frame)) == frame


@pytest.mark.parametrize("data", [b"", b"\x00" * 11, command("map")[:14], b"\xff" * 40])
def test_bytes_that_are_no_message_name_none_that_is_right(data):
    assert frame_of(data) != "map"


def test_what_is_in_another_frame_is_named_until_it_is_right():
    check = FrameCheck()
    assert not check.is_foreign("ego", command("map"))
    assert check.warning == ""
    assert check.is_foreign("objects", command("odom"))
    assert not check.is_foreign("ego", command(""))
    assert check.warning == "not used, since it is not in the frame 'map': objects in 'odom'"
    assert not check.is_foreign("objects", command("map"))
    assert check.warning == ""
