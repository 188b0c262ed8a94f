"""A model learns which lane changes must wait: from drives, by what came of each."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from roadmend.cli.main import main
from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.core.source_digest import source_digest
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.repair.adreft.model import AdreftModel
from roadmend.training.adreft import change_drives
from roadmend.training.adreft.case_risks import RiskPlan
from roadmend.training.adreft.change_drives import CarelessPolicy, changes_of_case
from roadmend.training.adreft.gathering import Recipe
from roadmend.world.corpus import corpus_of, save_corpus

from .cases import Drawn

SHIPPED = find_model("modular", "adreft-")
ROUTE = Route(
    "straight", 4.5, 1.8, 350.0, 60.0, (Stage(np.arange(0.0, 400.0, 2.0), np.zeros(200), np.full(200, 15.0)),), (), ()
)


def scene_of(places, time=0.0):
    """Cars by id at (x, y), and the ego at the origin."""
    x, y = ([place[axis] for place in places.values()] for axis in (0, 1))
    still = {"kind": 1, "yaw": 0.0, "acceleration": 0.0, "yaw_rate": 0.0}
    objects = ObjectList.of(id=[*places], x=x, y=y, speed=9.0, length=4.5, width=1.8, **still)
    ego = EgoState.from_yaw(0.0, 0.0, 0.0, 10.0, 0.0, 4.5, 1.8)
    return Scene(time, ego, objects, np.empty(0, np.uint8))


def decision_of(*, change_lane):
    return Decision(Command.from_action(0.0, change_lane=change_lane), Trajectory.empty())


def few(folder):
    """A corpus with three violations of the shipped one; changes of two of them end badly with the shipped model, too."""
    whole = corpus_of("modular")
    path = folder / "modular.jsonl"
    save_corpus(replace(whole, cases=tuple(whole.select("S5", "training", violation=True)[8:11])), path)
    return path


def plan(**changes):
    values = {
        "model": "modular",
        "digest": "x",
        "drives": 1,
        "horizon": 8.0,
        "plain": True,
        "history": False,
        "seed": 0,
    }
    return RiskPlan(**{**values, **changes})


class Asks:
    """A policy that notes whom it sees, and asks for a lane change at its second tick."""

    name = "asks"

    def __init__(self):
        self.seen = []

    def reset(self, route):
        self.seen.clear()

    def step(self, scene):
        self.seen.append({int(each) for each in scene.objects.id})
        return decision_of(change_lane=len(self.seen) == 2)


def test_the_careless_overlook_some_beside_them_until_they_ask():
    beside = {number: (20.0 - number, 3.5) for number in range(10, 40)}
    scene, policy = scene_of({1: (15.0, 0.0), **beside}), Asks()
    careless = CarelessPolicy(policy, 0.6, 3)
    careless.reset(ROUTE)
    for _ in range(3):
        careless.step(scene)
    first, second, third = policy.seen
    assert first == second
    assert 1 in first  # who is ahead in its own lane is seen by everybody
    assert 5 < len(first) < 25
    assert third == {int(each) for each in scene.objects.id}


def test_an_attentive_driver_sees_everybody():
    scene, policy = scene_of({2: (5.0, 3.5), 3: (-5.0, -3.5)}), Asks()
    careless = CarelessPolicy(policy, 0.0, 3)
    careless.reset(ROUTE)
    careless.step(scene)
    assert policy.seen == [{2, 3}]


def test_changes_of_a_drive_are_told_with_the_tokens_of_their_ticks():
    tokenizer = AdreftModel.load(SHIPPED).configuration.tokenizer
    found = changes_of_case(Drawn("S5", 3), Recipe("modular", tokenizer, 1), plan())
    assert len(found) >= 1
    assert found.tokens.shape[0] == found.counts.sum()
    assert found.collided.tolist() == [0.0] * len(found)
    again = changes_of_case(Drawn("S5", 3), Recipe("modular", tokenizer, 1), plan())
    assert np.array_equal(found.tokens, again.tokens)


def test_what_is_kept_goes_by_the_code_of_the_method_that_repairs():
    own = change_drives.__name__
    assert source_digest([own, "roadmend.repair.adreft.method"]) == source_digest([own])


def test_a_change_ends_badly_only_by_the_egos_own_fault_and_within_the_horizon(monkeypatch):
    def ended(at_fault, duration):
        def fake(_simulation, _policy, watch):
            for time in (1.0, 5.0):
                watch.reset(ROUTE)
                watch.step(scene_of({}, time), decision_of(change_lane=True))
            return SimpleNamespace(final=SimpleNamespace(at_fault=at_fault), duration=duration)

        monkeypatch.setattr(change_drives, "drive", fake)
        return changes_of_case(Drawn("S5", 3), Recipe("modular", "rich", 1), plan()).collided.tolist()

    assert ended(at_fault=True, duration=10.0) == [0.0, 1.0]
    assert ended(at_fault=True, duration=8.0) == [1.0, 1.0]
    assert ended(at_fault=False, duration=8.0) == [0.0, 0.0]


def test_a_model_gets_a_monitor_and_keeps_its_other_networks(tmp_path, capsys):
    out = tmp_path / "careful.safetensors"
    words = ["train", "changes", str(SHIPPED), "--policy", "modular", "--out", str(out), "--json", "--workers", "2"]
    words += [word for each in ("random_cases=6", "validation_cases=3", "epochs=1") for word in ("--set", each)]
    words += ["--set", 'families=["S5"]', "--corpus", str(few(tmp_path))]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    before, after = load_checkpoint(SHIPPED), load_checkpoint(out)
    kept = [name for name in before.tensors if not name.startswith("change.")]
    assert all(np.array_equal(before.tensors[name], after.tensors[name]) for name in kept)
    assert AdreftModel.load(out).change is not None
    assert after.header["change"]["threshold"] == told["threshold"]
    assert after.header["change"]["drivers"].keys() == {"modular"}
    assert after.header["ancestry"][0] == before.digest
    first = out.read_bytes()
    assert main(words) == 0  # what was driven is read again
    assert out.read_bytes() == first


def test_what_cannot_be_learned_from_is_said_and_nothing_is_written(tmp_path, capsys):
    out = tmp_path / "x.safetensors"
    words = ["train", "changes", str(SHIPPED), "--policy", "modular", "--out", str(out)]
    assert main([*words, "--also", "modular"]) == 2
    assert "'modular' is the policy itself" in capsys.readouterr().err
    assert main([*words, "--set", "epochs=0"]) == 2
    assert "epochs" in capsys.readouterr().err
    assert not out.exists()
