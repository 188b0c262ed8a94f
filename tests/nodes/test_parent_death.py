"""Nobody is left behind: not who is stopped when his launcher is killed, nor a relay whose campaign is."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

LAUNCHER = """
import pathlib, sys, time
from roadmend.nodes.children import Child

if __name__ == "__main__":
    child = Child("sleeper", "sleeps_for_ever", [], {}, pathlib.Path(sys.argv[1]), may_restart=False)
    child.start()
    print(child.process.pid, flush=True)
    time.sleep(600.0)
"""
SLEEPER = """
import time

def main(arguments):
    print("asleep", flush=True)
    time.sleep(600.0)
"""


def test_a_stopped_child_does_not_outlive_a_killed_launcher(tmp_path, monkeypatch):
    (tmp_path / "sleeps_for_ever.py").write_text(SLEEPER)
    (tmp_path / "launches.py").write_text(LAUNCHER)
    log = tmp_path / "log"
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    with subprocess.Popen(
        [sys.executable, tmp_path / "launches.py", log], stdout=subprocess.PIPE, text=True
    ) as launcher:
        child = int(launcher.stdout.readline())
        await_that(lambda: log.exists() and "asleep" in log.read_text())
        os.kill(child, signal.SIGSTOP)
        await_that(lambda: state_of(child) == "T")
        launcher.kill()
    await_that(lambda: state_of(child) in {"gone", "Z"})


def test_a_relay_of_a_campaign_does_not_outlive_it(domain, node, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    values = {"with_parent": True, "links": ["policy/command"], "distortion": "first_stranger"}
    words = " ".join(f"-p '{name}:={json.dumps(value)}'" for name, value in values.items())
    script = f"{sys.executable} -m roadmend.nodes.relay --ros-args {words} & echo $!; wait"
    watcher = node("watcher")
    with subprocess.Popen(["sh", "-c", script], stdout=subprocess.PIPE, text=True) as campaign:
        relay = int(campaign.stdout.readline())
        await_that(lambda: watcher.count_publishers("/policy/command"))
        campaign.kill()
        await_that(lambda: state_of(relay) in {"gone", "Z"})


def await_that(done):
    """Until something is so; fails if it does not come to be."""
    deadline = time.monotonic() + 60.0
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def state_of(process):
    """Its state as the kernel gives it: T of one that is stopped."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return "gone"
