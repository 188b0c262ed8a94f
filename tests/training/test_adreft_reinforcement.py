"""Reinforcement fine-tuning in a toy world in place of the simulation: it learns, resumes exactly and keeps the best."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.measures.case_result import CaseResult
from roadmend.networks.compiled_encoder import CompiledHead
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.model import AdreftModel
from roadmend.training.adreft.configuration import ModelSection, ReinforcementSection
from roadmend.training.adreft.exploring import Rolled, Transitions, explore
from roadmend.training.adreft.network import AdreftNetwork, save_model
from roadmend.training.adreft.reinforcement import ReinforcementStage
from roadmend.training.adreft.stage import RepairedPolicy, StageRun, TrainingSubject, spread
from roadmend.training.closed_loop import summarise
from roadmend.training.device import choose_torch_device
from roadmend.training.torch_state import tensors_of
from tests.measures.results import episode

MODEL = ModelSection(hidden=8, layers=1, heads=2, feed_forward=8, monitor=(4,), adapter=(24,)).configuration()
STEPS = 8


@dataclass(frozen=True)
class Toy:
    """A case: a row of states. Where a state's first number is positive, whoever does not brake at all collides."""

    seed: int
    is_violation: bool

    @property
    def name(self):
        return f"{self.seed}"

    @property
    def family(self):
        return f"S{1 + self.seed % 5}"

    digest = ""

    def states(self):
        states = np.random.default_rng(self.seed).normal(size=(STEPS, 8)).astype(np.float32)
        return states if self.is_violation else -np.abs(states)


TRAINING = [Toy(number, number % 2 == 0) for number in range(24)]
VALIDATION = [Toy(100 + number, number % 2 == 0) for number in range(20)]


def live(case, act):
    """Rewards as the paper's: 1 less half of the change to the policy's 0.8, and -10 for a collision, which ends it."""
    for state in case.states():
        index = act(state)
        collides = state[0] > 0.0 and ACTIONS[index] > -0.1
        yield state, index, -10.0 if collides else 1.0 - 0.5 * (0.8 - ACTIONS[index]), collides
        if collides:
            return


def toy_world(function, questions):
    for question in questions:
        if function is explore:
            yield toy_explore(question)
        else:
            yield toy_result(question, function.keywords["parameters"]["model"])


def toy_explore(roll):
    generator = np.random.default_rng(roll.seed)
    adapter = CompiledHead(roll.configuration.adapter_shape, roll.tensors, "adapter.")

    def act(state):
        return int(generator.integers(10)) if generator.random() < roll.epsilon else int(adapter.apply(state).argmax())

    rows = list(live(roll.case, act))
    states = np.array([row[0] for row in rows])
    after = np.concatenate([states[1:], np.zeros((1, 8), np.float32)])
    discount = np.array([roll.section.gamma] * (len(rows) - 1) + [0.0], np.float32)
    reward = np.array([row[2] for row in rows], np.float32)
    transitions = Transitions(states, np.array([row[1] for row in rows]), reward, discount, after)
    outcome = "COLLISION" if rows[-1][3] else "GOAL"
    return Rolled(transitions, roll.case.name, roll.case.is_violation, outcome, float(reward.sum()), 0.0)


def toy_result(case, model):
    loaded = AdreftModel.load(Path(model))
    rows = list(live(case, lambda state: int(loaded.values(state, 0.8).argmax())))
    dose = 0.05 * sum(0.8 - ACTIONS[row[1]] for row in rows)
    outcome = "COLLISION" if rows[-1][3] else "GOAL"
    return CaseResult(case.name, case.family, case.is_violation, episode(outcome, len(rows), len(rows), dose / 0.05))


def networks():
    torch.manual_seed(5)
    tensors = tensors_of(AdreftNetwork(MODEL))
    tensors["adapter.layers.1.bias"][0] += 3.0  # never brakes
    return tensors


def subject_of(training, validation):
    return TrainingSubject(RepairedPolicy("modular", "", "", training), validation)


def stage_of(state, mapper=toy_world, seed=3, tensors=None, validation=VALIDATION, **changes):
    values = {
        "episodes": 80,
        "round": 4,
        "learning_rate": 5e-3,
        "memory": 800,
        "batch": 32,
        "warm_up": 50,
        "target_every": 50,
        "gamma": 0.5,
        "validate_every": 10,
        "dose_weight": 10.0,
    }
    section = ReinforcementSection(**{**values, **changes})
    return ReinforcementStage(
        MODEL,
        tensors or networks(),
        0.5,
        section,
        subject_of(TRAINING, validation),
        StageRun(seed, "cpu", state),
        mapper=mapper,
    )


@pytest.fixture(autouse=True)
def _one_thread():
    choose_torch_device("cpu", 1)


def same(one, other):
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


def test_it_learns_to_brake_where_it_must_and_only_there(tmp_path):
    stage = stage_of(tmp_path / "state")
    tensors = stage.run()
    validated = [figures for figures in stage.history if figures.worth is not None]
    before, best = validated[0], max(validated, key=lambda figures: figures.worth)
    assert before.round == 0
    assert stage.history[-1].episodes == 80
    assert best.worth > before.worth + 20.0
    assert best.validation["fix"] >= 70.0
    adapter = CompiledHead(MODEL.adapter_shape, tensors, "adapter.")
    results = [toy_result_of(case, adapter) for case in VALIDATION if not case.is_violation]
    assert np.mean(results) > 0.0  # mostly without braking where nothing is in the way
    frozen = networks()
    assert all(np.array_equal(tensors[name], frozen[name]) for name in frozen if not name.startswith("adapter."))
    assert not same(tensors, frozen)


def toy_result_of(case, adapter):
    return np.mean([ACTIONS[int(adapter.apply(state).argmax())] for state in case.states()])


class StoppedError(Exception):
    pass


@pytest.mark.parametrize("changes", [{}, {"double": True, "loss": "huber", "start": "scratch", "keep": "last"}])
def test_an_interruption_changes_no_bit(tmp_path, changes):
    short = {"episodes": 40, "validate_every": 3, **changes}
    whole = stage_of(tmp_path / "whole", **short).run()

    def stops_after(last):
        def report(episodes, _figures):
            if episodes == last:
                raise StoppedError

        return report

    for last in (8, 28):
        with pytest.raises(StoppedError):
            stage_of(tmp_path / "pieces", **short).run(stops_after(last))
    stage = stage_of(tmp_path / "pieces", **short)
    assert stage.episode == 28
    assert same(stage.run(), whole)
    assert (tmp_path / "pieces").read_bytes() == (tmp_path / "whole").read_bytes()
    assert same(stage_of(tmp_path / "pieces", mapper=lambda *_: pytest.fail("drove"), **short).run(), whole)


def test_a_bad_run_keeps_what_it_began_with(tmp_path):
    """The best on validation is kept, and the beginning is one of those compared."""
    tensors = stage_of(tmp_path / "good").run()
    stage = stage_of(tmp_path / "bad", tensors=tensors, learning_rate=1.0, episodes=16, updates_per_step=5.0)
    kept = stage.run()
    validated = [figures for figures in stage.history if figures.worth is not None]
    assert (validated[0].round, len(validated)) == (0, 2)
    assert any(figures.worth < validated[0].worth for figures in validated)
    save_model(tmp_path / "kept.safetensors", MODEL, kept, 0.5)
    summary = summarise([toy_result(case, tmp_path / "kept.safetensors") for case in VALIDATION])
    assert summary.delta_e - 10.0 * summary.dose == max(figures.worth for figures in validated)


def test_a_state_of_another_training_is_refused(tmp_path):
    stage_of(tmp_path / "state", episodes=4).run()
    other = {name: value + np.float32(0.1) for name, value in networks().items()}
    for changes, name in (
        ({"seed": 4}, "seed"),
        ({"gamma": 0.4}, "reinforcement"),
        ({"tensors": other}, "networks"),
        ({"validation": VALIDATION[:2]}, "validation"),
    ):
        with pytest.raises(InputError, match=f"was begun with another '{name}'"):
            stage_of(tmp_path / "state", **{"episodes": 4, **changes})


def test_violations_have_their_share_of_the_episodes(tmp_path):
    driven = []

    def spying(function, questions):
        questions = list(questions)
        driven.extend(question.case for question in questions if function is explore)
        return toy_world(function, questions)

    stage_of(tmp_path / "state", mapper=spying, episodes=100, violation_share=0.7, keep="last").run()
    assert len(driven) == 100
    assert 55 <= sum(case.is_violation for case in driven) <= 85
    counts = [driven.count(case) for case in TRAINING if case.is_violation]
    assert max(counts) - min(counts) <= 1
    with pytest.raises(InputError, match="holds no success"):
        ReinforcementStage(
            MODEL,
            networks(),
            0.5,
            ReinforcementSection(),
            subject_of(TRAINING[::2], VALIDATION),
            StageRun(0, "cpu", tmp_path / "other"),
            mapper=toy_world,
        )


def test_validation_cases_are_spread_over_families_and_kinds():
    chosen = spread(VALIDATION, 10)
    assert {(case.family, case.is_violation) for case in chosen} == {
        (f"S{n}", kind) for n in range(1, 6) for kind in (True, False)
    }
    assert chosen == [case for case in VALIDATION if case in chosen]
    assert spread(VALIDATION, 0) == spread(VALIDATION, 99) == VALIDATION
