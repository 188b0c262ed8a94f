"""The real graph: node processes over DDS, real bags."""

import itertools
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

from roadmend.core.errors import InputError
from roadmend.nodes import launcher
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.policies.registry import make_policy
from roadmend.recording.info import bag_info
from roadmend.recording.reader import BagReader
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import load_scenario

pytestmark = pytest.mark.graph


def messages(bag, *topics):
    return [(message.topic, message.value) for message in BagReader(Path(bag)).messages(topics)]


@pytest.mark.parametrize(("family", "seed", "method"), [("S1", 4, "rss"), ("S5", 8, "predictive"), ("S4", 2, "random")])
def test_the_lockstep_graph_is_bit_identical_to_the_in_process_runner(
    family, seed, method, scenario_file, tmp_path, domain
):
    path = scenario_file(family, seed)
    graph = run_graph(GraphOptions(path, method=method, seed=3, bags=tmp_path, record=False, viz=False))
    alone = run_episode(load_scenario(path), make_policy("modular"), make_repairer(method, seed=3))
    assert graph.episode == alone
    assert graph.watchdog_ticks == graph.restarts == 0


def test_the_bag_holds_every_tick_and_says_how_it_ended(scenario_file, tmp_path, domain):
    path = scenario_file("S2", 5)
    result = run_graph(GraphOptions(path, bags=tmp_path, name="bag")).episode
    reader = BagReader(tmp_path / "bag")
    records = list(reader.records())
    counts = Counter(record.topic for record in records)
    told = reader.metadata["roadmend"]
    attached = {name: attachment.data for name, attachment in reader.attachments.items()}
    ticks = result.ticks + 1
    for topic in ("/clock", "/ego", "/objects"):
        # The first tick is repeated until it is answered, the more often the busier the machine: the stamps count.
        assert len({record.time_ns for record in records if record.topic == topic}) == ticks
    for topic in ("/policy/command", "/policy/trajectory", "/repair/command", "/repair/state"):
        assert counts[topic] >= result.ticks
    assert counts["/route"] == counts["/map"] == 1
    assert counts["/tf"] > 0 and counts["/markers/objects"] > 0  # noqa: PT018
    assert told["outcome"] == result.outcome.name
    assert told["method"] == "rss"
    assert attached[path.name] == path.read_bytes()


def test_it_drives_on_where_the_bag_cannot_be_written_any_further(scenario_file, tmp_path, domain):
    obstacle = tmp_path / "bag" / "bag_1.mcap"  # stands where the recorder wants its next file

    def obstruct(_text, _elapsed):
        if (obstacle.parent / "bag_0.mcap").exists():
            obstacle.mkdir(exist_ok=True)

    split = ("-p", "recorder_node:max_bagfile_duration:=1.0")
    options = GraphOptions(scenario_file("S2", 5), bags=tmp_path, name="bag", viz=False, ros_arguments=split)
    result = run_graph(options, obstruct)
    assert result.episode.reached_goal
    assert result.recording_error == f"{obstacle}: cannot be written (File exists)"
    obstacle.rmdir()
    assert bag_info(tmp_path / "bag").missing[0] == "metadata.yaml: is missing"


def test_decisions_in_the_bag_belong_to_the_tick_they_name(scenario_file, tmp_path, domain):
    run_graph(GraphOptions(scenario_file("S3", 3, time_limit=5.0), bags=tmp_path, name="bag", viz=False))
    seen = {}
    for topic, message in messages(tmp_path / "bag", "/objects", "/policy/command", "/repair/state", "/repair/command"):
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        seen.setdefault(topic, {})[stamp] = message
    for stamp, state in seen["/repair/state"].items():
        policy, final = seen["/policy/command"][stamp], seen["/repair/command"][stamp]
        assert state.policy_action == pytest.approx(policy.throttle - policy.brake)
        assert state.final_action == pytest.approx(final.throttle - final.brake)
        assert stamp in seen["/objects"]


def test_an_unknown_scenario_field_stops_the_graph_with_its_reason(tmp_path, domain):
    (tmp_path / "s.yaml").write_text("name: x\nspeed: 3\n")
    with pytest.raises(InputError, match="field"):
        run_graph(GraphOptions(tmp_path / "s.yaml", bags=tmp_path / "bags"))
    assert not list((tmp_path / "bags").glob("*/metadata.yaml"))


def test_a_taken_bag_is_not_overwritten(scenario_file, tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(InputError, match="exists already"):
        run_graph(GraphOptions(scenario_file("S1", 0), bags=tmp_path, name="bag"))


# -- faults, in real time so that there is time for them ---------------------------------------------------------------


def start_run(path, bags, *more):
    command = [
        sys.executable,
        "-m",
        "roadmend.cli",
        "run",
        "--scenario",
        str(path),
        "--out",
        str(bags),
        "--name",
        "bag",
    ]
    command += ["--no-viz", "--clock", "realtime", "--rate", "0.5", "--json", *more]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def parent_of(pid):
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


def node_process(run, node):
    """The process of one node of a run: the grandchild of the launcher that writes the node's log."""
    for _ in range(200):
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                log = (folder / "fd" / "1").readlink().name
                if log == f"{node}.log" and parent_of(parent_of(folder.name)) == run.pid:
                    return int(folder.name)
            except (OSError, ValueError, IndexError):
                continue
        time.sleep(0.05)
    pytest.fail(f"no process of {node}")


def wait_until_driving(bags):
    """Until the bag grows as it does only while the vehicle moves."""
    for _ in range(600):
        file = next(iter((bags / "bag").glob("*.mcap")), None)
        if file is not None and file.stat().st_size > 40_000:
            return
        time.sleep(0.05)
    pytest.fail("the graph did not start")


def standing_in(scenario_file):
    """Long enough to break things in."""
    return scenario_file("S3", 3, time_limit=5.0)


@pytest.mark.slow
def test_a_killed_policy_means_a_controlled_stop_until_it_is_back(scenario_file, tmp_path):
    run = start_run(standing_in(scenario_file), tmp_path)
    wait_until_driving(tmp_path)
    os.kill(node_process(run, "policy"), signal.SIGKILL)
    printed, complained = run.communicate(timeout=60)
    result = json.loads(printed)[0]
    assert result["restarts"] == 1, complained
    states = [message for _, message in messages(tmp_path / "bag", "/repair/state")]
    stale = [state for state in states if state.state == state.STALE_COMMAND]
    assert len(stale) >= 5
    assert all(state.final_action <= -0.4 for state in stale)
    assert states[-1].state != states[-1].STALE_COMMAND  # it was left again
    assert len(states) >= 0.8 * result["ticks"]  # the repair node never went silent


@pytest.mark.slow
def test_a_killed_repair_node_means_the_watchdog_brakes_until_it_is_back(scenario_file, tmp_path):
    run = start_run(standing_in(scenario_file), tmp_path)
    wait_until_driving(tmp_path)
    os.kill(node_process(run, "repair"), signal.SIGKILL)
    printed, complained = run.communicate(timeout=60)
    result = json.loads(printed)[0]
    assert result["restarts"] == 1, complained
    assert result["watchdog_ticks"] > 0
    events = [message for _, message in messages(tmp_path / "bag", "/events")]
    kinds = [event.kind for event in events]
    assert kinds.index(events[0].WATCHDOG) < kinds.index(events[0].RECOVERED)
    bitten = next(event for event in events if event.kind == event.WATCHDOG)
    speeds = [
        message.twist.twist.linear.x
        for _, message in messages(tmp_path / "bag", "/ego")
        if 0.3
        < (message.header.stamp.sec + message.header.stamp.nanosec * 1e-9)
        - (bitten.header.stamp.sec + bitten.header.stamp.nanosec * 1e-9)
        < 1.0
    ]
    assert all(after <= before for before, after in itertools.pairwise(speeds))


def test_interrupted_in_the_middle_everything_is_gone_within_3_s_and_the_bag_reads(scenario_file, tmp_path):
    run = start_run(scenario_file("S3", 3, time_limit=60.0), tmp_path)
    wait_until_driving(tmp_path)
    nodes = [node_process(run, node) for node in ("sim", "policy", "repair", "recorder")]
    run.send_signal(signal.SIGINT)
    _, complained = run.communicate(timeout=30)
    assert run.returncode == 130
    assert "interrupted" in complained
    assert not [pid for pid in nodes if Path(f"/proc/{pid}").exists()]
    assert launcher.STOP_S < 3.0  # what has not gone by then is killed
    events = [message for _, message in messages(tmp_path / "bag", "/events")]
    assert events[-1].kind == events[-1].ABORTED


def test_nothing_is_left_when_the_launcher_is_killed(scenario_file, tmp_path):
    run = start_run(scenario_file("S3", 3, time_limit=60.0), tmp_path)
    wait_until_driving(tmp_path)
    nodes = [node_process(run, node) for node in ("sim", "policy", "repair", "recorder")]
    run.kill()
    run.communicate(timeout=30)
    for _ in range(100):
        left = [pid for pid in nodes if Path(f"/proc/{pid}").exists()]
        if not left:
            return
        time.sleep(0.1)
    pytest.fail(f"still there: {left}")


def test_interrupted_after_a_node_died_the_bag_still_reads(scenario_file, tmp_path):
    """A killed node says no goodbye; the recorder must not wait for it until it is killed itself."""
    run = start_run(scenario_file("S3", 3, time_limit=60.0), tmp_path)
    wait_until_driving(tmp_path)
    os.kill(node_process(run, "policy"), signal.SIGKILL)
    time.sleep(0.5)
    run.send_signal(signal.SIGINT)
    run.communicate(timeout=30)
    assert run.returncode == 130
    assert messages(tmp_path / "bag", "/events")[-1][1].kind == 5  # ABORTED
