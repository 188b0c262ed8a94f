"""Generations: what is kept, what goes on where it stopped, and ends that are honest. Driving and tuning are acted."""

import json
from dataclasses import replace

import pytest

from roadmend.core.errors import InputError
from roadmend.language.chat import AnswerError
from roadmend.language.exchange import load_exchanges
from roadmend.measures.driving import DrivingMeasures
from roadmend.sera.analysis import BagAnalysis
from roadmend.sera.analysis_report import NOTHING
from roadmend.sera.backends import Backend
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.cycle import Cycle, CycleOptions, PolicyEvaluation, TunedPolicy
from roadmend.sera.describe import entry_of
from roadmend.sera.incident import Other
from roadmend.sera.language_analyser import LanguageAnalyser
from roadmend.sera.language_reflection import LanguageReflector
from roadmend.world.families import sample_scenario

from ..language.server import texts  # noqa: TID252 - one server for all rooms
from .recorded import incident
from .speaking import speaking

TRUCK = Other(7, "truck", "cut_in", "left", 9.0, 0.0, "cut_in", "v7", "reckless")


def measured(score):
    return DrivingMeasures("GOAL", 100.0, (), score, score == 100.0, 90.0, 80.0, at_fault=False)


class Stage:
    """Acts the steps of a cycle; fails where it is told to, and counts what it is asked for."""

    def __init__(self, folder, failing=99, epochs=3):
        self.folder = folder
        self.failing = failing  # evaluations that leave a bag
        self.epochs = epochs
        self.asked = []
        self.learned = []

    def identity(self, policy):
        return policy

    def evaluate(self, policy):
        number = sum(step == "evaluate" for step in self.asked)
        self.asked.append("evaluate")
        bag = self.folder / f"bag {number}"
        bag.mkdir(parents=True, exist_ok=True)
        return PolicyEvaluation((measured(50.0 + 10.0 * number),), (bag,) if number < self.failing else ())

    def read(self, bags):
        self.asked.append("read")
        return [BagAnalysis(str(bag), (incident(bag=str(bag), other=TRUCK),)) for bag in bags]

    def tune(self, policy, scenarios, selection, out):
        self.asked.append("tune")
        self.learned.append([scenario.name for scenario in scenarios])
        out.write_text("weights")
        return TunedPolicy(out, self.epochs, 60.0, 50.0)


@pytest.fixture(scope="module")
def bank(tmp_path_factory):
    path = tmp_path_factory.mktemp("bank") / "b.bank"
    build_bank(path, [entry_of(sample_scenario(family, seed), "test") for seed in range(6) for family in ("S3", "S4")])
    with Bank(path) as opened:
        yield opened


@pytest.fixture
def cycle(bank, tmp_path):
    def run(stage=None, backend=None, of=bank, **options):
        stage = stage or Stage(tmp_path / "bags")
        backend = backend or Backend.open("embedded")
        given = CycleOptions(**{"generations": 2, "scenarios": 2} | options)
        return [*Cycle(of, backend, stage, ["evaluated"], tmp_path / "cycle", given).run("neural.safetensors")], stage

    return run


def test_generations_drive_learn_and_drive_again(cycle, tmp_path):
    found, stage = cycle()
    assert stage.asked == ["evaluate", "read", "tune"] * 2 + ["evaluate"]
    assert [one.summary["driving_score"]["mean"] for one in found] == [50.0, 60.0, 70.0]
    assert found[0].policy == "neural.safetensors"
    assert found[2].policy == str(tmp_path / "cycle" / "generation-1" / "model.safetensors")
    assert (found[0].incidents, len(found[0].patterns), len(found[0].selected)) == (1, 1, 2)
    assert found[2].tuned is None
    assert "a truck cuts in" in (tmp_path / "cycle" / "generation-0" / "analysis.md").read_text(encoding="utf-8")


def test_every_generation_learns_from_scenarios_that_are_new_to_it(cycle):
    _, stage = cycle(generations=3)
    names = [name for learned in stage.learned for name in learned]
    assert len(names) == len({*names}) == 6


def test_it_goes_on_where_it_stopped_and_does_again_what_was_decided_otherwise(cycle, tmp_path):
    first, _ = cycle()
    again, stage = cycle()
    assert again == first
    assert stage.asked == ["evaluate"] * 3
    (tmp_path / "cycle" / "generation-1" / "model.safetensors").unlink()
    assert cycle()[1].asked == ["evaluate", "evaluate", "tune", "evaluate"]
    (tmp_path / "cycle" / "generation-0" / "analysis.json").write_text('{"key": ')
    assert cycle()[1].asked == ["evaluate", "read", "evaluate", "evaluate"]
    assert cycle(settings="other")[1].asked == ["evaluate", "read", "tune"] * 2 + ["evaluate"]
    assert "tune" in cycle(settings="other", scenarios=1)[1].asked


def test_what_was_recommended_and_is_not_in_the_bank_is_an_error_that_says_so(cycle, tmp_path):
    cycle()
    path = tmp_path / "cycle" / "generation-0" / "recommendation.json"
    content = json.loads(path.read_text("utf-8"))
    content["refined"][0] |= {"digest": "0" * 64, "name": "lost"}
    path.write_text(json.dumps(content), "utf-8")
    with pytest.raises(InputError, match=r"recommendation.json: lost is not in .*; remove the file to choose anew"):
        cycle()


def test_given_bags_are_learned_from_first(cycle, tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    cycle(first_bags=(given,))
    read = [json.loads((tmp_path / "cycle" / f"generation-{n}" / "analysis.json").read_text())["bags"] for n in (0, 1)]
    assert read == [[str(given)], [str(tmp_path / "bags" / "bag 1")]]


def test_where_nothing_fails_it_ends_and_says_so(cycle, tmp_path):
    found, stage = cycle(Stage(tmp_path / "bags", failing=1))
    assert stage.asked == ["evaluate", "read", "tune", "evaluate", "read"]
    assert found[-1].notes == (NOTHING,)
    assert found[-1].tuned is None


def test_a_pattern_without_known_words_is_left_out_and_said(cycle, bank, monkeypatch, tmp_path):
    class Odd(Stage):
        def read(self, bags):
            strange = incident(bag="b", kind="timeout", other=None)
            return [*super().read(bags), BagAnalysis("b", (strange,)), BagAnalysis("c", problem="c: is corrupt")]

    embed = bank.embed

    def deaf(pattern):
        if pattern.what == "TIMEOUT":
            raise InputError("pattern 'time-out'", "says nothing that this bank knows", "name a road")
        return embed(pattern)

    monkeypatch.setattr(bank, "embed", deaf)
    found, stage = cycle(Odd(tmp_path / "bags"), generations=1)
    assert "tune" in stage.asked
    assert found[0].notes == (
        "not read: c: is corrupt",
        "left out: pattern 'time-out': says nothing that this bank knows; name a road",
    )
    monkeypatch.setattr(bank, "embed", lambda _: deaf(replace_outcome()))
    found, stage = cycle(generations=1, settings="deaf to all")
    assert "tune" not in stage.asked
    assert found[0].notes[0].startswith("left out: ")


def replace_outcome():
    return type("Pattern", (), {"what": "TIMEOUT"})()


def test_a_policy_that_nothing_improves_goes_on_unchanged(cycle, tmp_path):
    found, _ = cycle(Stage(tmp_path / "bags", epochs=0))
    assert [one.policy for one in found] == ["neural.safetensors"] * 3
    assert found[0].notes == ("no epoch was better than the policy as it was, which goes on unchanged",)


def test_an_empty_bank_or_one_of_descriptions_ends_it_with_a_note(cycle, tmp_path, bank):
    build_bank(tmp_path / "empty", [])
    build_bank(tmp_path / "described", [replace(entry, scenario=None) for entry in bank.entries()])
    for name in ("empty", "described"):
        with Bank(tmp_path / name) as poor:
            found, stage = cycle(of=poor, settings=name)
        assert "tune" not in stage.asked
        assert found[-1].notes == ("the bank has no scenario that can be driven and was not learned from before",)


def test_what_a_language_model_was_asked_is_kept_though_nothing_came_of_it(cycle, tmp_path):
    with speaking({"analysis": "...", "patterns": []}) as (model, _):
        opened = Backend.open("embedded")
        asking = Backend(LanguageAnalyser(model, 1), opened.reflector, model)
        with pytest.raises(AnswerError, match="of no pattern"):
            cycle(backend=asking)
    kept = tmp_path / "cycle" / "generation-0" / "language.exchanges.jsonl"
    assert len(kept.read_text(encoding="utf-8").splitlines()) == 1


def test_what_an_interrupted_generation_was_told_stays_when_it_goes_on(cycle, tmp_path):
    def shown(body):
        (one,) = json.loads(texts(body)[2])["incidents"]
        pattern = {"name": "cut-in", "words": "A truck cuts in at the exit.", "what": one["what"], "evidence": [1]}
        return {"analysis": "...", "patterns": [pattern | {part: one[part] for part in ("where", "who", "why")}]}

    kept = tmp_path / "cycle" / "generation-0" / "language.exchanges.jsonl"
    with speaking(shown, "no answer", {"analysis": "...", "swaps": []}) as (model, _):
        asking = Backend(LanguageAnalyser(model, 1), LanguageReflector(model, 1), model)
        with pytest.raises(AnswerError):
            cycle(backend=asking, generations=1)
        cycle(backend=asking, generations=1)
        cycle(backend=asking, generations=1)
    told = [None if each.reply is None else each.reply.text for each in load_exchanges(kept)]
    assert [each[:13] for each in told] == ['{"analysis": ', "no answer", '{"analysis": ']
