"""What the system shows of processes that somebody else has started."""

import os
import subprocess
import sys
import uuid

from roadmend.faults.processes import command_of, end_all, left_of


def test_who_was_started_with_a_mark_is_found_and_ended():
    mark = f"MARK={uuid.uuid4()}"
    name, _, value = mark.partition("=")
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, env={**os.environ, name: value})
    try:
        assert left_of(mark) == [child.pid]
        assert "input()" in command_of(child.pid)
        end_all(mark)
        assert child.wait(30) == -9
        assert left_of(mark) == []
        assert command_of(child.pid) == ""
    finally:
        child.kill()
        child.communicate()
