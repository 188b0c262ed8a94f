"""sera_node over DDS: services that answer, and say what is wrong where they cannot."""

import shutil
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from roadmend_msgs import msg, srv

from roadmend.core.errors import InputError
from roadmend.nodes.children import Child, stop
from roadmend.nodes.pattern_messages import pattern_message_of, patterns_of
from roadmend.nodes.sera import SeraNode
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.describe import entry_of
from roadmend.sera.pattern import FailurePattern, PatternEvidence, Where, Who, Why, read_patterns
from roadmend.world.families import sample_scenario

from ..language.server import serving  # noqa: TID252 - one server for all rooms
from ..sera.speaking import KEY, as_completion  # noqa: TID252 - likewise

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"
FULL = FailurePattern(
    "cut-in",
    "a truck cuts in",
    "COLLISION",
    Where("S4", "highway_exit", "priority", 2, 27.78, "dense", "rainy", "nighttime"),
    Who("truck", "left", "reckless"),
    Why("exit", "cut_in", 0.0),
    (PatternEvidence("a", "5" * 64, 1.5, "late"), PatternEvidence("b")),
)


@pytest.fixture(scope="module")
def bank(tmp_path_factory):
    path = tmp_path_factory.mktemp("bank") / "b.bank"
    build_bank(path, [entry_of(sample_scenario(family, seed), "test") for seed in range(4) for family in ("S3", "S4")])
    return path


@pytest.fixture
def caller(domain, tmp_path):
    """Starts the node in a process of its own and gives a function that calls its services."""
    rclpy.init(domain_id=domain)
    node, executor = Node("caller"), SingleThreadedExecutor()
    executor.add_node(node)
    children = []

    def begin(environment=None, **parameters):
        given = [part for name, value in parameters.items() for part in ("-p", f"{name}:={value}")]
        arguments = ["--ros-args", "--log-level", "warn", *given]
        child = Child(
            "sera_node", "roadmend.nodes.sera", arguments, environment or {}, tmp_path / "node.log", may_restart=False
        )
        children.append(child)
        child.start()

        def call(kind, name, **request):
            client = node.create_client(kind, f"sera_node/{name}")
            assert client.wait_for_service(60.0), child.log.read_text()
            future = client.call_async(kind.Request(**request))
            while not future.done():
                assert child.exit_code is None, child.log.read_text()
                executor.spin_once(timeout_sec=0.1)
            return future.result()

        return call

    yield begin
    stop(children, time.monotonic() + 60.0)
    codes = [child.exit_code for child in children]
    node.destroy_node()
    rclpy.try_shutdown()
    assert codes == [0] * len(children)


@pytest.mark.graph
def test_from_bags_to_scenarios_and_every_fault_is_an_answer(caller, bank, tmp_path):
    call = caller(bank=bank, count=3)
    found = call(srv.AnalyseBag, "analyse_bag", bags=[str(SAMPLES / "collision")])
    assert (found.success, found.unreadable) == (True, [])
    (pattern,) = found.patterns
    assert (pattern.outcome, pattern.participant, pattern.hazard) == ("COLLISION", "car", "cut_in_and_brake")
    assert "at 27.80 s" in found.report
    chosen = call(srv.Recommend, "recommend", patterns=found.patterns)
    assert chosen.success, chosen.message
    assert len(chosen.name) == len(chosen.score) == 3
    assert {*chosen.pattern} == {0}
    with Bank(bank) as opened:
        assert {*chosen.digest} <= {entry.digest for entry in opened.entries()}
    other = call(srv.Recommend, "recommend", patterns=found.patterns, count=2, exclude=chosen.digest)
    assert not {*other.digest} & {*chosen.digest}
    assert len(other.digest) == 2

    shutil.copytree(SAMPLES / "collision", tmp_path / "bags" / "torn")
    (file,) = (tmp_path / "bags" / "torn").glob("*.mcap")
    file.write_bytes(file.read_bytes()[:5000])
    torn = call(srv.AnalyseBag, "analyse_bag", bags=[str(tmp_path / "bags"), str(SAMPLES / "collision")])
    assert (torn.success, len(torn.patterns), len(torn.unreadable)) == (False, 1, 1)
    assert "was cut short or is corrupt" in torn.unreadable[0]
    for faulty, complaint in (
        (call(srv.AnalyseBag, "analyse_bag"), "bags: there is none"),
        (call(srv.AnalyseBag, "analyse_bag", bags=["/nowhere"]), "there is no such bag"),
        (call(srv.Recommend, "recommend"), "patterns: there is none"),
        (call(srv.Recommend, "recommend", patterns=[msg.FailurePattern(weather="hail")]), "where.weather"),
        (
            call(srv.Recommend, "recommend", patterns=[msg.FailurePattern(words="zorblax")]),
            "says nothing that this bank",
        ),
        (call(srv.Recommend, "recommend", patterns=found.patterns, count=10**6), "is too many"),
    ):
        assert not faulty.success
        assert complaint in faulty.message
    assert call(srv.Recommend, "recommend", patterns=found.patterns).success  # alive after all that


@pytest.mark.graph
def test_a_language_model_that_invents_is_an_error_in_the_answer_and_on_record(caller, tmp_path):
    kept = tmp_path / "said.exchanges.jsonl"
    with serving(as_completion({"analysis": "...", "patterns": []})) as (server, url):
        there = {"OPENAI_BASE_URL": url, "OPENAI_API_KEY": KEY}
        call = caller(there, backend="openai", attempts=2, exchanges=kept)
        answer = call(srv.AnalyseBag, "analyse_bag", bags=[str(SAMPLES / "collision")])
        assert "2 answers for the failure patterns were rejected" in answer.message
        lacking = call(srv.Recommend, "recommend", patterns=[msg.FailurePattern(words="rain")])
        assert "parameter bank: names no bank" in lacking.message
    assert len(server.requests) == 2
    assert len(kept.read_text(encoding="utf-8").splitlines()) == 2
    assert KEY not in kept.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("parameter", "complaint"),
    [
        ("bank:=/nowhere.bank", "no such file"),
        ("backend:=oracle", "parameter backend: there is no 'oracle'"),
        ("backend:=replay", "has no recording"),
        ("count:=0", "parameter count"),
    ],
)
def test_what_cannot_work_is_refused_at_the_start(domain, tmp_path, monkeypatch, parameter, complaint):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    rclpy.init(args=["test", "--ros-args", "-p", parameter], domain_id=domain)
    try:
        with pytest.raises(InputError, match=complaint):
            SeraNode()
    finally:
        rclpy.try_shutdown()


def test_a_model_without_a_place_for_what_is_said_is_refused(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    rclpy.init(args=["test", "--ros-args", "-p", "backend:=openai"], domain_id=domain)
    try:
        with pytest.raises(InputError, match="no place for what is said; set the parameter exchanges"):
            SeraNode()
    finally:
        rclpy.try_shutdown()


@pytest.mark.parametrize("pattern", [FULL, FailurePattern("x"), FailurePattern("y", where=Where(lanes=1))])
def test_a_pattern_survives_the_message(pattern):
    assert patterns_of([pattern_message_of(pattern)]) == [pattern]


@pytest.mark.parametrize(
    ("field", "value", "complaint"),
    [
        ("speed_limit", np.nan, "speed_limit is nan"),
        ("evidence_note", ["one"], "differ in length .0, 0, 0, 1."),
        ("outcome", "GRIEF", "what"),
    ],
)
def test_a_message_that_is_no_pattern_is_refused(field, value, complaint):
    message = pattern_message_of(FailurePattern("x"))
    setattr(message, field, value)
    with pytest.raises(InputError, match=complaint):
        patterns_of([message])


def test_words_in_a_file_and_in_a_message_are_one(tmp_path):
    (given,) = read_patterns("rain at an exit")
    assert patterns_of([pattern_message_of(given)]) == [given]
