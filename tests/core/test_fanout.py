"""Work side by side: answers in order, whatever the number of workers, and nobody left working when it stops."""

import os
import signal
import subprocess
import sys
import threading
import time
from multiprocessing import connection
from pathlib import Path
from types import SimpleNamespace

import pytest

from roadmend.core import fanout
from roadmend.core.errors import InputError, SimulationError
from roadmend.core.fanout import fan_out

PARENT = """
import os, sys, time
from roadmend.core.fanout import fan_out

def work(_number):
    os.write(1, f"{os.getpid()}\\n".encode())  # at once: a print's number and its newline may come apart
    time.sleep(600.0)

if __name__ == "__main__":
    try:
        with fan_out(2) as mapper:
            list(mapper(work, range(9)))
    except KeyboardInterrupt:
        sys.exit(130)
"""


def slower_first(number):
    time.sleep(0.2 if number == 0 else 0.0)
    return number * number


def refuse(number):
    raise InputError("number", f"{number} is unusable", "give another")


def die(_number):
    os.kill(os.getpid(), signal.SIGKILL)


def die_later(number):
    time.sleep(0.1)
    if number > 5:
        die(number)


@pytest.mark.parametrize("workers", [1, 2])
def test_answers_come_in_the_order_of_the_questions(workers):
    with fan_out(workers) as mapper:
        assert list(mapper(slower_first, range(6))) == [0, 1, 4, 9, 16, 25]


def test_no_process_is_started_for_one_piece_of_work():
    with fan_out(8, most=1) as mapper:
        assert list(mapper(lambda _: os.getpid(), [0])) == [os.getpid()]  # a lambda could not travel, either
    with fan_out(8, most=0) as mapper:
        assert list(mapper(refuse, [])) == []


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_comes_out_as_it_went_in(workers):
    with pytest.raises(InputError, match="number: 3 is unusable; give another"), fan_out(workers) as mapper:
        list(mapper(refuse, [3, 4]))


def test_a_worker_that_dies_is_said_in_one_line():
    with pytest.raises(SimulationError, match="a worker process died; run the same command"), fan_out(2) as mapper:
        for _ in mapper(die_later, range(9)):
            pass


def test_workers_that_die_at_once_name_the_guard_that_a_script_needs():
    guard = r"died before any had answered; .* under 'if __name__ == \"__main__\":' only"
    with pytest.raises(SimulationError, match=guard), fan_out(2) as mapper:
        list(mapper(die, range(2)))


def start_parent(folder):
    (folder / "parent.py").write_text(PARENT)
    parent = subprocess.Popen([sys.executable, folder / "parent.py"], stdout=subprocess.PIPE, text=True)
    return parent, [int(parent.stdout.readline()) for _ in range(2)]


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"  # ended, not yet buried
    except FileNotFoundError:
        return False


def all_gone(workers):
    deadline = time.monotonic() + 60.0
    while any(map(is_alive, workers)) and time.monotonic() < deadline:
        time.sleep(0.1)
    return not any(map(is_alive, workers))


def test_workers_end_when_their_parent_is_killed_in_the_middle_of_their_work(tmp_path):
    parent, workers = start_parent(tmp_path)
    assert all(map(is_alive, workers))
    parent.kill()
    parent.wait()
    assert all_gone(workers)


def test_an_interrupt_ends_work_that_would_take_long(tmp_path):
    parent, workers = start_parent(tmp_path)
    parent.send_signal(signal.SIGINT)
    assert parent.wait(60.0) == 130
    assert all_gone(workers)
    assert parent.stdout.read() == ""  # nothing new was begun


class CarefulEnd:
    """An end of a pipe that bears one hand at a time, and takes its time to close."""

    def __init__(self, end):
        self._end, self._closing = end, threading.Lock()

    def close(self):
        assert self._closing.acquire(blocking=False)
        time.sleep(0.3)
        self._end.close()
        self._closing.release()


def test_who_gave_up_has_closed_the_leash_before_it_is_closed_at_the_end(monkeypatch):
    def pipe(duplex):
        leash, end = connection.Pipe(duplex)
        return leash, CarefulEnd(end)

    def begin():
        raise RuntimeError("give up")

    monkeypatch.setattr(fanout, "connection", SimpleNamespace(Pipe=pipe))
    monkeypatch.setattr(fanout, "_GRACE", 0.0)
    with pytest.raises(RuntimeError, match="give up"), fan_out(2):
        begin()
