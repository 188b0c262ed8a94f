"""The real graph: node processes over DDS, real bags."""

import itertools
import os
import signal
import time
from collections import Counter
from pathlib import Path

import pytest
from roadmend_msgs.msg import RepairState, ScenarioEvent

from roadmend.core.errors import InputError
from roadmend.nodes import launcher, qos
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.policies.registry import make_policy
from roadmend.recording.info import bag_info
from roadmend.recording.reader import BagReader
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import load_scenario

from .graph_run import Run, records, stamp_of

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


@pytest.fixture
def run(domain, scenario_file, tmp_path):
    """Starts a run that lasts two minutes if nobody ends it."""
    started = []

    def start():
        path = scenario_file("S3", 3, time_limit=60.0)
        started.append(Run(path, tmp_path, "--clock", "realtime", "--rate", "0.5"))
        started[-1].until_driving(settled=False)
        return started[-1]

    yield start
    for one in started:
        one.close()


@pytest.mark.slow
def test_a_killed_policy_means_a_controlled_stop_until_it_is_back(run):
    there = run()
    os.kill(there.node("policy_node"), signal.SIGKILL)
    there.until_said("policy_node ended (-9), restarted")
    there.until_seen("/repair/state", RepairState, lambda state: state.state != state.STALE_COMMAND)
    code, said = there.interrupt()
    assert code == 130, said
    states = records(there.bag, "/repair/state")
    stale = [state for state in states if state.state == state.STALE_COMMAND]
    assert stale
    assert all(state.final_action <= -0.4 for state in stale)
    assert {state.state for state in states[states.index(stale[0]) :]} - {stale[0].state}  # it was left again
    ticks = {stamp_of(ego) for ego in records(there.bag, "/ego")}
    assert len(states) >= 0.8 * len(ticks)  # the repair node never went silent


@pytest.mark.slow
def test_a_killed_repair_node_means_the_watchdog_brakes_until_it_is_back(run):
    there = run()
    os.kill(there.node("repair_node"), signal.SIGKILL)
    there.until_said("repair_node ended (-9), restarted")
    there.until_seen("/events", ScenarioEvent, lambda event: event.kind == event.RECOVERED, ticks=0, profile=qos.EVENT)
    code, said = there.interrupt()
    assert code == 130, said
    events = records(there.bag, "/events")
    kinds = [event.kind for event in events]
    assert kinds.index(events[0].WATCHDOG) < kinds.index(events[0].RECOVERED)
    bitten = stamp_of(events[kinds.index(events[0].WATCHDOG)])
    egos = records(there.bag, "/ego")
    speeds = [ego.twist.twist.linear.x for ego in egos if 3 * 10**8 < stamp_of(ego) - bitten < 10**9]
    assert all(after <= before for before, after in itertools.pairwise(speeds))


def test_interrupted_in_the_middle_everything_is_gone_within_3_s_and_the_bag_reads(run):
    there = run()
    nodes = [there.node(f"{name}_node") for name in ("sim", "policy", "repair", "recorder")]
    code, said = there.interrupt()
    assert code == 130
    assert "interrupted" in said
    assert not [pid for pid in nodes if Path(f"/proc/{pid}").exists()]
    assert launcher.STOP_S < 3.0  # what has not gone by then is killed
    events = records(there.bag, "/events")
    assert events[-1].kind == events[-1].ABORTED


def test_nothing_is_left_when_the_launcher_is_killed(run):
    there = run()
    nodes = [there.node(f"{name}_node") for name in ("sim", "policy", "repair", "recorder")]
    there.process.kill()
    there.process.wait()
    for _ in range(600):
        left = [pid for pid in nodes if Path(f"/proc/{pid}").exists()]
        if not left:
            return
        time.sleep(0.1)
    pytest.fail(f"still there: {left}")


def test_interrupted_after_a_node_died_the_bag_still_reads(run):
    """A killed node says no goodbye; the recorder must not wait for it until it is killed itself."""
    there = run()
    os.kill(there.node("policy_node"), signal.SIGKILL)
    there.until_said("policy_node ended (-9)")
    code, _ = there.interrupt()
    assert code == 130
    events = records(there.bag, "/events")
    assert events[-1].kind == events[-1].ABORTED
