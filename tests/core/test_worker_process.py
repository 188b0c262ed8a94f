"""A pool's workers: they are gone when their parent is, however it went."""

import subprocess
import sys
import time
from pathlib import Path

PARENT = """
import multiprocessing, os, sys, time
from concurrent.futures import ProcessPoolExecutor
from roadmend.core.worker_process import begin_worker

def work(_number):
    print(os.getpid(), flush=True)
    time.sleep(600.0)

if __name__ == "__main__":
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context, initializer=begin_worker) as pool:
        list(pool.map(work, range(2)))
"""


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"  # ended, not yet buried
    except FileNotFoundError:
        return False


def test_workers_end_when_their_parent_is_killed_in_the_middle_of_their_work(tmp_path):
    (tmp_path / "parent.py").write_text(PARENT)
    parent = subprocess.Popen([sys.executable, tmp_path / "parent.py"], stdout=subprocess.PIPE, text=True)
    workers = [int(parent.stdout.readline()) for _ in range(2)]
    assert all(map(is_alive, workers))
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 60.0
    while any(map(is_alive, workers)) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not any(map(is_alive, workers))
