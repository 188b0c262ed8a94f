"""``roadmend sera evaluate``: real episodes in this process, their bags, and what is left out."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from roadmend.cli.main import main
from roadmend.measures.driving import MeasuresObserver
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTicks
from roadmend.world.corpus import load_corpus, save_corpus
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario

CORPUS = Path(__file__).parents[2] / "config" / "corpora" / "modular.jsonl"


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """The shortest violation and the shortest success of the shipped corpus's crossings."""
    whole = load_corpus(CORPUS)
    cases = [
        min(whole.select("S3", "validation", violation=kind), key=lambda case: case.duration) for kind in (True, False)
    ]
    path = tmp_path_factory.mktemp("corpus") / "two.jsonl"
    save_corpus(replace(whole, cases=tuple(cases)), path)
    return path


@pytest.fixture
def evaluate(corpus, tmp_path, capsys):
    def run(*arguments, out="out", code=0):
        given = ["--corpus", str(corpus), "--workers", "1", "--out", str(tmp_path / out), "--json", *arguments]
        assert main(["sera", "evaluate", *given]) == code
        return json.loads(capsys.readouterr().out), tmp_path / out

    return run


def measures_of(ticks):
    """What the observer of a run makes of the scenes in its bag."""
    observer = None
    for tick in ticks:
        if tick.route is not None:
            route, observer = tick.route, MeasuresObserver(tick.route)
        observer.see(tick.scene(route))
    return observer.measures(tick.final)


def test_bags_tell_the_same_measures_as_the_runs_and_an_interrupted_call_goes_on(evaluate, capsys):
    told, out = evaluate("--record", "all")
    assert sorted(one["measures"]["outcome"] for one in told["episodes"]) == ["COLLISION", "GOAL"]
    for one in told["episodes"]:
        bag = BagReader(out / "bags" / one["bag"])
        measured = measures_of(BagTicks(bag))
        assert asdict(measured) == one["measures"] | {"infractions": tuple(one["measures"]["infractions"])}
        assert bag.metadata["roadmend"]["outcome"] == one["measures"]["outcome"]
    assert told["summary"]["success_rate"]["mean"] == 50.0
    assert told["families"]["S3"]["episodes"] == 2
    kept = (out / "results.jsonl").read_text().splitlines(keepends=True)
    (out / "results.jsonl").write_text("".join(kept[:2]))  # as if the call had ended after the first episode
    again, _ = evaluate("--record", "all")
    assert again["episodes"] == told["episodes"]
    assert (out / "results.jsonl").read_text() == "".join(kept)
    assert "Driving Score" in (out / "measures.md").read_text()


def test_failures_alone_are_recorded_and_can_be_analysed(evaluate, capsys):
    told, out = evaluate()
    assert [bool(one["bag"]) for one in told["episodes"]] == [
        one["measures"]["outcome"] != "GOAL" for one in told["episodes"]
    ]
    assert main(["sera", "analyse", str(out / "bags"), "--workers", "1", "--json"]) == 0
    (incident,) = json.loads(capsys.readouterr().out)["incidents"]
    assert incident["kind"] == "collision"
    assert incident["where"]["family"] == "S3"


def test_what_is_known_is_left_out_under_whatever_name(tmp_path, capsys):
    known = tmp_path / "known.yaml"
    save_scenario(sample_scenario("S4", 5).model_copy(update={"name": "renamed"}), known)
    given = ["--scenarios", "1", "--first-seed", "5", "--disjoint-from", str(known), "--record", "none", "--json"]
    assert main(["sera", "evaluate", *given, "--out", str(tmp_path / "out"), "--workers", "1"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["left_out"] == 1
    options = f"--scenarios 1 --first-seed 5 --disjoint-from {known} --record none"
    assert told["provenance"]["command"] == f"./roadmend sera evaluate --policy modular --repair none {options}"
    assert [one["family"] for one in told["episodes"]] == ["S1", "S2", "S3", "S5"]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--scenarios", "2"], "--corpus: leaves nothing to draw"),
        (["--disjoint-from", "{corpus}"], "the evaluation set: holds no scenario that is not known"),
        (["--disjoint-from", "{corpus}.not"], "cannot be read (No such file or directory)"),
    ],
)
def test_a_set_that_is_none_is_one_line_and_leaves_nothing(corpus, tmp_path, capsys, arguments, line):
    given = [each.format(corpus=corpus) for each in arguments]
    assert main(["sera", "evaluate", "--corpus", str(corpus), "--out", str(tmp_path / "out"), *given]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert line in said
    assert main(["sera", "evaluate", "--split", "test", "--out", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()
