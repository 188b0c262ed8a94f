"""A folder for the while of a run goes with it, however the run ends."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from roadmend.nodes.scratch import scratch_folder

HOLDER = """
import sys, time
from roadmend.nodes.scratch import scratch_folder
if __name__ == "__main__":
    with scratch_folder("roadmend-test-") as folder:
        (folder / "file").write_text("x")
        print(folder, flush=True)
        time.sleep(60)
"""


def test_it_is_there_and_then_it_is_not():
    with scratch_folder("roadmend-test-") as folder:
        (folder / "file").touch()
        assert folder.name.startswith("roadmend-test-")
    assert not folder.exists()
    with pytest.raises(ValueError, match="why"), scratch_folder("roadmend-test-") as folder:
        raise ValueError("why")
    assert not folder.exists()


SLOW_HOLDER = """
import os, sys, time
from roadmend.nodes import scratch
start = scratch.CONTEXT.Process.start
def slowly(process):
    print(os.getpid(), flush=True)
    start(process)
    time.sleep(2)
scratch.CONTEXT.Process.start = slowly
if __name__ == "__main__":
    with scratch.scratch_folder("roadmend-test-"):
        time.sleep(60)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_nothing_is_left_of_one_that_is_ended_while_it_begins(tmp_path, number):
    script, own = tmp_path / "holder.py", tmp_path / "own"
    script.write_text(SLOW_HOLDER)
    own.mkdir()
    environment = os.environ | {"TMPDIR": str(own)}
    holder = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    )
    holder.stdout.readline()
    time.sleep(0.3)
    holder.send_signal(number)
    assert holder.wait() != 0
    holder.stdout.close()
    for _ in range(100):
        left = [*own.glob("roadmend-test-*")]
        if not left:
            break
        time.sleep(0.05)
    assert not left


@pytest.mark.slow
def test_it_is_removed_after_its_maker_was_killed_and_all_who_write_into_it_have_gone(tmp_path):
    script = tmp_path / "holder.py"
    script.write_text(HOLDER)
    holder = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    folder = Path(holder.stdout.readline().strip())
    with (folder / "node.log").open("w") as log:
        writer = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, stdout=log)
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()  # not for the end of what it says: multiprocessing's own processes hold that open
    holder.stdout.close()
    time.sleep(1.0)
    assert (folder / "file").exists()
    writer.communicate(b"\n")
    for _ in range(200):
        if not folder.exists():
            return
        time.sleep(0.05)
    pytest.fail("it is still there")
