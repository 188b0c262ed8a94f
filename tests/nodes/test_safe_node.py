"""safe_node in a process of its own, asked over DDS by an action client."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
import yaml
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import DescribeParameters
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from roadmend_msgs.action import BuildCrashScenarios

from roadmend.language.exchange import dump_exchanges
from roadmend.language.openai_chat import OpenAIModel, OpenAISettings
from roadmend.nodes import qos
from roadmend.nodes.domain import own_domain
from roadmend.nodes.safe import main
from roadmend.recording import topics
from roadmend.safe.dsl_file import parse_crash_scenario
from roadmend.safe.report import report_of_text
from roadmend.safe.stage_one import LanguageExtractor, StageOneOptions
from roadmend.world.scenario_file import load_scenario

from ..language.server import completion, serving  # noqa: TID252 - one server for three rooms

LIMIT_S = 200.0  # [s] for what takes one on a machine that is not full
SUMMARY = (
    "V1, a 2010 Ford Focus, was northbound on a two-lane road with a posted limit of 35 mph. It was raining in "
    "daylight. V2, a Jeep Wrangler, was stopped ahead of it. The front of V1 struck the rear of V2."
)
TRUTH = {
    "road_type": "Straight",
    "num_lanes": 2,
    "stem_direction": None,
    "vehicles": [
        {"model": "Sedan", "initial_position": "S2N", "action": "Move Forward", "speed_limit_mph": 35},
        {"model": "SUV", "initial_position": "S2N", "action": "Move Forward", "speed_limit_mph": 35},
    ],
    "env": {"time": "Daytime", "weather": "Rainy"},
    "collisions": [{"striking": 1, "struck": 2, "striking_side": "Front", "struck_side": "Rear"}],
}
ANSWERS = {
    "meta_message": {
        "analysis": "",
        "road_type": "Straight",
        "number_of_vehicles": 2,
        "driving_directions": ["S2N", "S2N"],
    },
    "scenario": {"analysis": "", "scenario": TRUTH},
}


def recorded():
    """What a model says that rejects its first answer."""
    verdicts = [{"verdict": "Fail", "problems": ["look again"]}, *[{"verdict": "Pass", "problems": []}] * 2]

    def answer(body):
        purpose = body["response_format"]["json_schema"]["name"]
        return completion(json.dumps(verdicts.pop(0) if purpose == "validation" else ANSWERS[purpose]))

    with serving(answer) as (_, url):
        model = OpenAIModel(OpenAISettings(base_url=url, model="test", api_key="secret", attempts=1))
        return LanguageExtractor(model, StageOneOptions()).extract(report_of_text("told", SUMMARY)).exchanges


class Client(Node):
    """Asks, and keeps what comes back."""

    def __init__(self, context):
        super().__init__("client", context=context)
        self.executor_ = SingleThreadedExecutor(context=context)
        self.executor_.add_node(self)
        self.action = ActionClient(self, BuildCrashScenarios, "safe_node/build")
        self.health = []
        self.create_subscription(DiagnosticArray, topics.DIAGNOSTICS, self.health.append, qos.DIAGNOSTIC)
        self.until(self.action.server_is_ready)

    def until(self, done):
        limit = time.monotonic() + LIMIT_S
        while not done():
            assert time.monotonic() < limit, "nothing came"
            self.executor_.spin_once(timeout_sec=0.05)

    def wait(self, future):
        self.until(future.done)
        return future.result()

    def begin(self, steps, **goal):
        def keep(message):
            feedback = message.feedback
            steps.append((feedback.stage, feedback.attempt, feedback.total))

        return self.wait(self.action.send_goal_async(BuildCrashScenarios.Goal(**goal), keep))

    def ask(self, told=0, **goal):
        """The result, asked for once there are ``told`` steps: rclpy drops feedback that comes with or after it."""
        steps = []
        handle = self.begin(steps, **goal)
        self.until(lambda: len(steps) >= told)
        answer = self.wait(handle.get_result_async())
        return answer.status, answer.result, steps


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("safe_node")


@pytest.fixture(scope="module")
def graph(folder):
    """The node's process, and a context on its domain."""
    recording = folder / "told.exchanges.jsonl"
    recording.write_text(dump_exchanges(recorded()))
    with own_domain() as domain:
        environment = {name: value for name, value in os.environ.items() if not name.startswith("OPENAI")} | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }
        given = ["-p", f"output:={folder / 'out'}", "-p", f"recording:={recording}"]
        command = [sys.executable, "-m", "roadmend.nodes.safe", "--ros-args", *given]
        child = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        try:
            yield child, context
        finally:
            rclpy.shutdown(context=context)
            child.kill()
            child.communicate()


@pytest.fixture(scope="module")
def client(graph):
    node = Client(graph[1])
    yield node
    node.destroy_node()


@pytest.mark.graph
class TestGoals:
    def test_a_text_is_read_and_built(self, client, folder):
        status, result, steps = client.ask(told=5, summary=SUMMARY, name="told", samples=2, seed=3)
        assert (status, result.success, result.error) == (GoalStatus.STATUS_SUCCEEDED, True, "")
        assert steps == [("read", 1, 1), *[("build", number, 4) for number in (1, 2, 3, 4)]]
        assert yaml.safe_load(result.crash)["env"] == TRUTH["env"]
        kept = Path(result.crash_file)
        assert parse_crash_scenario(kept.read_text(), ".json", "") == parse_crash_scenario(result.crash, ".yaml", "")
        assert kept.parent == folder / "out"
        assert [load_scenario(Path(file)).origin.vehicle for file in result.scenarios] == [1, 1, 2, 2]
        assert Path(result.page) == folder / "out" / "told.html"
        assert "<title>told" in Path(result.page).read_text(encoding="utf-8")
        assert "sketch: there is none" in result.notes

    def test_a_path_is_read_and_not_built(self, client, folder):
        report = folder / "night" / "summary.txt"
        report.parent.mkdir()
        report.write_text("V1, a 2010 Ford Focus, went east at night. It hit the rear of V2, a Jeep Wrangler.")
        _, result, steps = client.ask(told=1, report=str(report.parent))
        assert (result.success, result.scenarios, steps) == (True, [], [("read", 1, 1)])
        assert "num_lanes" in result.open_fields
        assert Path(result.crash_file).name == "night.json"

    def test_a_model_is_asked_again_where_its_answer_did_not_pass(self, client):
        _, result, steps = client.ask(told=7, summary=SUMMARY, name="told", backend="replay")
        assert result.error == ""
        assert steps == [
            ("read", 1, 1),
            ("meta_message", 1, 3),
            ("validation", 1, 3),
            ("meta_message", 2, 3),
            ("validation", 2, 3),
            ("scenario", 1, 3),
            ("validation", 1, 3),
        ]
        assert yaml.safe_load(result.crash) == TRUTH

    @pytest.mark.parametrize(
        ("goal", "said"),
        [
            ({}, "the goal: has not one of report and summary"),
            ({"report": "somewhere", "summary": SUMMARY}, "the goal: has not one of report and summary"),
            ({"report": "nowhere"}, "nowhere: no such report or folder"),
            ({"summary": " \n"}, "the summary: is empty"),
            ({"summary": "V1 \x01\x02"}, "the summary: is no text"),
            ({"summary": "V1 " * 30_000}, "the summary: is longer than"),
            ({"summary": SUMMARY, "name": "../told"}, "name '../told': cannot be a file's"),
            ({"summary": SUMMARY, "samples": 4_000_000_000}, "samples: 4000000000 is too many"),
            ({"summary": SUMMARY, "backend": "oracle"}, "backend: there is no 'oracle'"),
            ({"summary": SUMMARY, "backend": "openai"}, "OPENAI_API_KEY: is not set"),
            ({"summary": "Something else", "backend": "replay"}, "the recording has no (further) answer"),
            ({"summary": "The road was empty."}, "the summary speaks of no vehicle"),
        ],
    )
    def test_bad_input_is_said_in_the_result(self, client, goal, said):
        status, result, _ = client.ask(**goal)
        assert (status, result.success) == (GoalStatus.STATUS_ABORTED, False)
        assert said in result.error
        assert "\n" not in result.error
        assert (result.crash, result.scenarios) == ("", [])

    @pytest.mark.parametrize("content", [b"", b"\x89PNG\r\n\x1a\n\x00\x00"])
    def test_a_file_that_is_no_report(self, client, folder, content):
        file = folder / "broken.txt"
        file.write_bytes(content)
        _, result, _ = client.ask(report=str(file))
        assert result.error.startswith(f"{file}: is ")

    def test_a_folder_of_reports_is_too_many(self, client, folder):
        for name in ("one.txt", "two.txt"):
            (folder / "many").mkdir(exist_ok=True)
            (folder / "many" / name).write_text(SUMMARY)
        assert "holds 2 reports" in client.ask(report=str(folder / "many"))[1].error

    def test_a_goal_is_cancelled_between_two_steps_and_another_has_its_turn(self, client):
        steps, waiting = [], []
        goal = client.begin(steps, summary=SUMMARY, name="long", samples=1000)
        other = client.begin(waiting, summary=SUMMARY, name="waiting")
        client.until(lambda: ("build", 1, 2000) in steps)
        assert waiting == []
        assert len(client.wait(goal.cancel_goal_async()).goals_canceling) == 1
        answer = client.wait(goal.get_result_async())
        assert (answer.status, answer.result.error) == (GoalStatus.STATUS_CANCELED, "cancelled")
        assert len(steps) < 2000
        assert client.wait(other.get_result_async()).result.success
        assert waiting == [("read", 1, 1)]

    def test_a_goal_that_waits_can_be_cancelled(self, client):
        goal = client.begin([], summary=SUMMARY, name="long", samples=1000)
        waiting = []
        other = client.begin(waiting, summary=SUMMARY)
        for each in (other, goal):
            client.wait(each.cancel_goal_async())
        assert client.wait(other.get_result_async()).status == GoalStatus.STATUS_CANCELED
        assert waiting == []
        client.wait(goal.get_result_async())

    def test_parameters_describe_themselves(self, client):
        describe = client.create_client(DescribeParameters, "safe_node/describe_parameters")
        names = ["backend", "output", "settings", "recording", "attempts"]
        client.until(describe.service_is_ready)
        answer = client.wait(describe.call_async(DescribeParameters.Request(names=names)))
        assert all(each.description for each in answer.descriptors)
        assert answer.descriptors[0].additional_constraints.startswith("one of embedded, openai, replay, or ")
        assert answer.descriptors[4].integer_range[0].to_value == 20

    def test_its_health(self, client):
        client.health.clear()
        client.until(lambda: client.health)
        status = client.health[-1].status[0]
        assert (status.name, status.message) == ("/safe_node", "waiting for goals")

    def test_it_ends_in_the_middle_of_a_goal(self, client, graph):  # the last one: it takes the node with it
        steps = []
        client.begin(steps, summary=SUMMARY, name="long", samples=1000)
        client.until(lambda: len(steps) > 2)
        graph[0].send_signal(signal.SIGTERM)
        assert graph[0].wait(30) == 0


@pytest.mark.parametrize(
    ("given", "said"),
    [("backend:=oracle", "parameter backend: there is no 'oracle'"), ("attempts:=0", "parameter attempts")],
)
def test_a_bad_parameter_is_refused(given, said, domain, capsys):
    assert main(["safe_node", "--ros-args", "-p", given]) == 2
    assert said in capsys.readouterr().err
