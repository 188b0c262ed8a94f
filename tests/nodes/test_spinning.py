"""How a node process ends: not before those who listen have what it said."""

import os
import signal
from pathlib import Path

import pytest

from roadmend.nodes.loopback import reach
from roadmend.recording.reader import BagReader

COUNT = 1000  # twice what Fast DDS's shared memory holds of one process


@pytest.mark.graph
def test_a_node_that_has_finished_goes_when_a_recorder_that_was_halted_has_all_of_it(start, tmp_path):
    environment = os.environ | reach() | {"ROS_LOG_DIR": str(tmp_path / "log")}
    words = ["--ros-args", "-p", f"output:={tmp_path}", "-p", "name:=bag"]
    recorder = start("-m", "roadmend.nodes.recorder", *words, env=environment)
    leaver = start(Path(__file__).with_name("leaver.py"), COUNT, env=environment)
    assert "connected\n" in leaver.stdout
    recorder.send_signal(signal.SIGSTOP)
    leaver.stdin.write("\n")
    leaver.stdin.flush()
    assert "published\n" in leaver.stdout
    recorder.send_signal(signal.SIGCONT)
    assert leaver.wait(60) == 0
    recorder.terminate()
    assert recorder.wait(60) == 0
    bag = BagReader(tmp_path / "bag")
    assert [message.value.data for message in bag.messages(["/text"])] == [str(number) for number in range(COUNT)]
    assert bag.metadata["roadmend"]["lost_messages"] == "0"
