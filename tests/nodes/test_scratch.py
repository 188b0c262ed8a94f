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
