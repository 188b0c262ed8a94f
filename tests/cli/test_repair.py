"""``roadmend repair`` beside the example's stack: two terminals, real DDS, no simulator."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from roadmend.cli.main import main
from roadmend.recording.reader import BagReader

pytestmark = [pytest.mark.graph, pytest.mark.slow, pytest.mark.timeout(600)]

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "src" / "examples" / "own_graph.py"
PAGE = ROOT / "src" / "doc" / "own-graph.md"
PATIENCE_S = 120.0
ARGUMENTS = ["--ego", "/odom", "--objects", "/detections", "--objects-type", "vision_msgs/msg/Detection3DArray"]
ARGUMENTS += ["--command", "/drive/accel", "--command-type", "geometry_msgs/msg/AccelStamped"]
ARGUMENTS += ["--repaired", "/drive/repaired"]


class Repair:
    """The command as a process, and what it says."""

    def __init__(self, *arguments):
        command = [sys.executable, "-m", "roadmend.cli", "repair", *arguments]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.said = ""
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in self.process.stderr:
            self.said += line

    def wait_for(self, text):
        end = time.monotonic() + PATIENCE_S
        while text not in self.said:
            assert time.monotonic() < end, self.said
            assert self.process.poll() is None, self.said
            time.sleep(0.1)

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        out, _ = self.process.communicate(timeout=PATIENCE_S)
        return json.loads(out)


@pytest.fixture
def repair():
    made = []

    def start(*arguments):
        made.append(Repair(*arguments))
        return made[-1]

    yield start
    for one in made:
        one.process.kill()


def drive(*arguments):
    return subprocess.run(
        [sys.executable, str(EXAMPLE), *arguments], capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )


def test_what_collides_bare_stops_under_repair_and_the_bag_tells_why(domain, repair, tmp_path):
    bare = drive("--bare")
    assert (bare.returncode, bare.stdout[:8]) == (1, "collided")

    # Patience for a machine that is busy with other tests.
    running = repair(
        *ARGUMENTS, "--out", str(tmp_path), "--name", "bag", "--json", "--ros-args", "-p", "input_timeout:=5.0"
    )
    running.wait_for("waits for /odom (nav_msgs/msg/Odometry, any QoS): nobody publishes it in ROS_DOMAIN_ID")
    assert f"ROS_DOMAIN_ID {domain}" in running.said
    repaired = drive()
    assert (repaired.returncode, repaired.stdout[:7]) == (0, "stopped"), (
        repaired.stdout + repaired.stderr + running.said
    )
    told = running.stop()
    assert running.process.returncode == 0
    assert told["interventions"] >= told["states"]["REPAIRED"] > 5
    assert told["restarts"] == 0

    reader = BagReader(Path(told["bag"]))
    assert {"/odom", "/detections", "/drive/accel", "/drive/repaired", "/repair/state"} <= set(reader.topics)
    states = [one.value for one in reader.messages(["/repair/state"]) if one.value.state == 1]
    assert states[0].method == "rss"
    assert len(states[0].trigger_id) == 1
    assert "no planned trajectory" in states[0].reason
    assert reader.start_ns > 10**18  # without a clock the wall's time is the bag's
    picture = tmp_path / "stopped.png"
    assert main(["bag", "plot", told["bag"], *ARGUMENTS[:4], "--out", str(picture)]) == 0
    assert picture.stat().st_size > 20_000


@pytest.mark.usefixtures("domain")
def test_the_example_says_once_that_nobody_answers():
    waiting = subprocess.Popen(
        [sys.executable, str(EXAMPLE)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        line = waiting.stderr.readline()
        waiting.send_signal(signal.SIGINT)
        out, more = waiting.communicate(timeout=PATIENCE_S)
    finally:
        waiting.kill()
    assert line.startswith("own_graph: no answer on /drive/repaired for 5 s; start './roadmend repair'")
    assert (out, more) == ("interrupted\n", "")


def test_it_is_started_again_when_it_dies(domain, repair):
    running = repair(*ARGUMENTS, "--no-record", "--json")
    running.wait_for("waits for /odom")
    children = Path(f"/proc/{running.process.pid}/task/{running.process.pid}/children").read_text().split()
    nodes = [number for child in children for number in _below(child) if _name(number) == "repair_node"]
    assert len(nodes) == 1
    os.kill(int(nodes[0]), signal.SIGKILL)
    running.wait_for("repair_node ended (-9), restarted")
    assert running.stop()["restarts"] == 1


def _below(process):
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [process, *(number for child in children for number in _below(child))]


def _name(process):
    return Path(f"/proc/{process}/comm").read_text().strip()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--ros-args", "-p", "ego_length:=-1.0"], "parameter ego_length"),
        (["--repair", "adreft", "--ros-args", "-p", "adreft.model:=nothing"], "nothing"),
        (["--objects-type", "x/msg/Y"], "'x/msg/Y' is not one of"),
        (["--name", "../up"], "--name: '../up' is no name for a folder"),
    ],
)
def test_a_users_mistake_is_one_line(domain, tmp_path, arguments, message):
    command = [sys.executable, "-m", "roadmend.cli", "repair", "--out", str(tmp_path), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.returncode == 2, done.stderr
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("roadmend: ")
    assert message in last
    assert done.stderr.count(last) == 1, "it is said once"
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_page_shows_the_commands_that_are_tried_here(capsys):
    page = PAGE.read_text(encoding="utf-8").replace("\\\n", " ")
    assert " ".join(ARGUMENTS) in " ".join(page.split())
    assert "src/examples/own_graph.py" in page
    assert main(["repair", "--help"]) == 0
    assert "--objects-type" in capsys.readouterr().out
