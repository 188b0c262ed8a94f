"""Node processes: each starts in the environment of the moment, however old the server is that forks it."""

import json
import signal
import subprocess
import sys
import time

import pytest

from roadmend.core.errors import InputError
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
from multiprocessing import forkserver, util
from roadmend.nodes.children import CONTEXT, start_forked

def sleeps():
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    time.sleep(60.0)

spawn = util.spawnv_passfds

def interrupted_at_once(*arguments):
    server = spawn(*arguments)
    for _ in range(WHEN):
        time.sleep(0.01)
    os.kill(server, signal.SIGINT)
    return server

if __name__ == "__main__":
    util.spawnv_passfds = interrupted_at_once
    process = CONTEXT.Process(target=sleeps)
    start_forked(process)
    server = forkserver._forkserver._forkserver_pid
    assert os.waitpid(server, os.WNOHANG) == (0, 0)
    time.sleep(0.5)
    os.kill(process.pid, signal.SIGINT)  # nothing holds back what is meant for the process itself
    process.join(30.0)
    print(process.exitcode)
"""


@pytest.mark.parametrize("centiseconds", [0, 1, 10, 60])
def test_an_interrupt_is_no_affair_of_the_server_from_its_first_moment(tmp_path, centiseconds):
    script = tmp_path / "script.py"
    script.write_text(INTERRUPTED.replace("WHEN", str(centiseconds)))
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert (done.stdout, done.stderr) == (f"{-signal.SIGINT}\n", "")


def test_a_folder_for_temporary_files_whose_path_is_too_long_is_named(tmp_path, monkeypatch):
    long = tmp_path / ("x" * 100)
    long.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(long))
    with pytest.raises(InputError, match=r"TMPDIR: .*x is too long a path .* at most 75 characters"):
        Child("one", "one", [], {}, tmp_path / "log", may_restart=False).start()
