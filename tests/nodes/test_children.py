"""Node processes: each starts in the environment of the moment, however old the server is that forks it."""

import json
import signal
import subprocess
import sys
import time

import pytest

from roadmend.nodes.children import Child

MODULE = """
import json, os

def main(arguments):
    print(json.dumps({name: value for name, value in os.environ.items() if name.startswith("ROADMEND_TEST")}))
    return 0
"""


@pytest.fixture
def told(tmp_path, monkeypatch):
    """Starts a child that prints its environment, and reads what it printed."""
    (tmp_path / "tells_its_environment.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)

    def start(environment):
        log = tmp_path / "log"
        log.unlink(missing_ok=True)
        child = Child("teller", "tells_its_environment", [], environment, log, may_restart=False)
        child.start()
        child.process.join(60.0)
        assert child.exit_code == 0, log.read_text()
        return json.loads(log.read_text())

    return start


def test_a_child_sees_the_environment_as_it_is_and_not_as_it_was(told, monkeypatch):
    monkeypatch.setenv("ROADMEND_TEST_DOMAIN", "1")
    assert told({}) == {"ROADMEND_TEST_DOMAIN": "1"}
    monkeypatch.setenv("ROADMEND_TEST_DOMAIN", "2")
    assert told({}) == {"ROADMEND_TEST_DOMAIN": "2"}
    assert told({"ROADMEND_TEST_DOMAIN": "3"}) == {"ROADMEND_TEST_DOMAIN": "3"}
    monkeypatch.delenv("ROADMEND_TEST_DOMAIN")
    assert told({"ROADMEND_TEST_OWN": "4"}) == {"ROADMEND_TEST_OWN": "4"}


SLEEPS = """
import time

def main(arguments):
    print("here", flush=True)
    time.sleep(60.0)
"""


def test_an_interrupt_before_a_node_has_a_handler_ends_it_without_a_traceback(tmp_path, monkeypatch):
    (tmp_path / "sleeps_without_a_handler.py").write_text(SLEEPS)
    monkeypatch.syspath_prepend(tmp_path)
    log = tmp_path / "log"
    child = Child("sleeper", "sleeps_without_a_handler", [], {}, log, may_restart=False)
    child.start()
    deadline = time.monotonic() + 50.0
    while not (log.exists() and log.read_text()) and time.monotonic() < deadline:
        time.sleep(0.02)
    child.interrupt()
    child.process.join(60.0)
    assert (child.exit_code, log.read_text()) == (-signal.SIGINT, "here\n")


INTERRUPTED = """
import os, signal, time
from multiprocessing import forkserver
from roadmend.nodes.children import CONTEXT

def quiet():
    pass

if __name__ == "__main__":
    forkserver.ensure_running()
    server = forkserver._forkserver._forkserver_pid
    for _ in range(200):
        time.sleep(0.01)
        with open(f"/proc/{server}/status") as status:
            ignored = next(int(line.split()[1], 16) for line in status if line.startswith("SigIgn"))
        if ignored & 1 << signal.SIGINT - 1:
            break
    os.kill(server, signal.SIGINT)
    process = CONTEXT.Process(target=quiet)
    process.start()
    process.join()
    assert forkserver._forkserver._forkserver_pid == server
    print(process.exitcode)
"""


def test_an_interrupt_while_the_server_imports_is_no_affair_of_its(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(INTERRUPTED)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert (done.stdout, done.stderr) == ("0\n", "")
