"""Few-shot repair with a tiny budget: the guard, the header, and that it repeats."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.core.source_digest import source_digest
from roadmend.measures.driving import DrivingMeasures
from roadmend.networks.checkpoint import find_model, load_checkpoint, save_checkpoint
from roadmend.policies.neural import NeuralPolicy
from roadmend.training import few_shot
from roadmend.training.demonstrations import gather
from roadmend.training.few_shot import Labour, TuningOrigin, few_shot_repair, lessons_of, replay_lessons
from roadmend.training.few_shot_settings import FewShotSettings, read_few_shot_settings
from roadmend.training.samples import Samples
from roadmend.world.corpus import load_corpus
from roadmend.world.families import sample_scenario

torch.set_num_threads(1)
SETTINGS = FewShotSettings(epochs=3, replay=1, validation=1, every=10, learning_rate=1e-3)
GOOD = DrivingMeasures("GOAL", 100.0, (), 100.0, True, None, None, False)
BAD = replace(GOOD, outcome="COLLISION", driving_score=30.0, success=False)
CONFIG = Path(__file__).parents[2] / "config"
MODEL = find_model("neural")


@pytest.fixture(scope="module")
def scenarios():
    return [sample_scenario("S3", 240_200), sample_scenario("S5", 240_201)]


@pytest.fixture(scope="module")
def kept(scenarios) -> dict[str, Samples]:
    """What the lessons of these tests come to: driven once."""
    return {}


@pytest.fixture
def gathering(kept):
    def answer(lessons) -> Iterator[Samples]:
        for lesson in lessons:
            key = f"{lesson.draw}/{lesson.model}/{lesson.repair}"
            if key not in kept:
                kept[key] = gather(lesson)
            yield kept[key]

    return answer


def repair(scenarios, out, gathering, hard, ordinary, **more):
    """A repair whose policy fares on the validation set as the two say, in the order in which it is driven there."""
    turns = {True: iter(hard), False: iter(ordinary)}

    def driving(_model, chosen):
        return iter([GOOD if next(turns[chosen[0] is scenarios[0]]) else BAD] * len(chosen))

    arguments = {
        "settings": SETTINGS,
        "seed": 1,
        "out": out,
        "labour": Labour(gathering=gathering, driving=driving),
        **more,
    }
    found = few_shot_repair(MODEL, scenarios, **arguments)
    assert not [*turns[True], *turns[False]]  # nothing was left undriven
    return found


def test_the_first_of_the_best_epochs_is_kept_and_the_header_tells_where_it_comes_from(tmp_path, scenarios, gathering):
    out = tmp_path / "new" / "tuned.safetensors"
    origin = TuningOrigin("selection-digest", "bank-digest", "command")
    found = repair(scenarios, out, gathering, [0, 0, 1, 1], [1, 1], origin=origin)
    assert found.kept.epochs == 2
    assert [trial.epochs for trial in found.trials] == [0, 1, 2, 3]
    model = load_checkpoint(out, "neural")
    assert model.header["ancestry"][0] == load_checkpoint(MODEL).digest
    told = model.header["configuration"]["few_shot"]
    assert (told["selection"], told["bank"], told["seed"]) == ("selection-digest", "bank-digest", 1)
    assert told["settings"] == SETTINGS.model_dump(mode="json")
    assert told["scenarios"] == [scenario.digest for scenario in scenarios]
    assert model.header["metrics"]["kept"]["epochs"] == 2
    assert NeuralPolicy(out).model_digest == found.digest
    assert [path.name for path in out.parent.iterdir()] == [out.name]


def test_an_epoch_that_forgets_is_not_kept_however_good_it_is_elsewhere(tmp_path, scenarios, gathering):
    out = tmp_path / "tuned.safetensors"
    found = repair(scenarios, out, gathering, [0, 1, 1, 1, 1, 1], [1, 0, 0, 0, 0, 0])
    assert found.kept.epochs == 0
    assert [(trial.epochs, trial.share) for trial in found.trials[-2:]] == [(1, 0.5), (1, 0.25)]
    before, after = load_checkpoint(MODEL).tensors, load_checkpoint(out).tensors
    assert all((before[name] == after[name]).all() for name in before)


def test_the_best_epoch_that_forgets_nothing_is_kept(tmp_path, scenarios, gathering):
    found = repair(scenarios, tmp_path / "tuned.safetensors", gathering, [0, 1, 0, 1], [1, 0, 1])
    assert found.kept.epochs == 3
    assert [trial.ordinary for trial in found.trials] == [100.0, 30.0, None, 100.0]


def test_half_of_a_change_that_forgets_is_kept_where_it_forgets_nothing(tmp_path, scenarios, gathering):
    whole, half = tmp_path / "whole.safetensors", tmp_path / "half.safetensors"
    settings = SETTINGS.model_copy(update={"epochs": 1, "mixtures": (0.5,)})
    repair(scenarios, whole, gathering, [0, 1], [1, 1], settings=settings)
    found = repair(scenarios, half, gathering, [0, 1, 1], [1, 0, 1], settings=settings)
    assert (found.kept.epochs, found.kept.share) == (1, 0.5)
    old, new, mixed = (load_checkpoint(path).tensors for path in (MODEL, whole, half))
    for name in old:
        np.testing.assert_allclose(mixed[name], (old[name] + new[name]) / 2, atol=1e-6)


def test_ordinary_scenarios_are_not_driven_for_what_is_no_better(tmp_path, scenarios, gathering):
    found = repair(scenarios, tmp_path / "tuned.safetensors", gathering, [0, 0, 0, 0], [1])
    assert [trial.epochs for trial in found.trials] == [0, 1, 2, 3]
    assert found.kept == found.trials[0]


def test_without_the_guard_nothing_is_driven_and_the_last_epoch_is_kept(tmp_path, scenarios, gathering):
    out = tmp_path / "tuned.safetensors"
    found = repair(scenarios, out, gathering, [], [], settings=SETTINGS.model_copy(update={"keep": "last"}))
    assert found.kept == found.trials[-1]
    assert [(trial.epochs, trial.driving_score) for trial in found.trials] == [(1, None), (2, None), (3, None)]
    before, after = load_checkpoint(MODEL).tensors, load_checkpoint(out).tensors
    assert any((before[name] != after[name]).any() for name in before)


def test_the_same_seed_gives_the_same_file_and_another_does_not(tmp_path, scenarios, gathering):
    scores = [0, 1, 1, 1], [1, 1]
    first = repair(scenarios, tmp_path / "a.safetensors", gathering, *scores)
    again = repair(scenarios, tmp_path / "b.safetensors", gathering, *scores)
    other = repair(scenarios, tmp_path / "c.safetensors", gathering, *scores, seed=2)
    assert first.digest == again.digest != other.digest


def test_a_repaired_policy_can_be_repaired_again_and_remembers_all_its_ancestors(tmp_path, scenarios, gathering):
    scores = [0, 1, 1, 1], [1, 1]
    first = repair(scenarios, tmp_path / "a.safetensors", gathering, *scores)
    settings = SETTINGS.model_copy(update={"epochs": 1, "replay": 0})
    again = few_shot_repair(
        first.path,
        scenarios,
        settings,
        0,
        tmp_path / "b.safetensors",
        labour=Labour(gathering=gathering, driving=lambda _model, chosen: iter([GOOD] * len(chosen))),
    )
    assert load_checkpoint(again.path).header["ancestry"][:2] == [first.digest, load_checkpoint(MODEL).digest]


def test_demonstrations_are_driven_by_the_expert_and_by_the_policy(scenarios):
    settings = SETTINGS.model_copy(update={"expert_drives": 2, "policy_drives": 1})
    lessons = lessons_of(scenarios[0], MODEL, settings)
    assert [lesson.model for lesson in lessons] == [None, None, MODEL]
    assert len({(lesson.draw, lesson.model) for lesson in lessons}) == 3


def test_adreft_brings_demonstrations_to_their_goal_that_the_expert_does_not():
    cases = load_corpus(CONFIG / "corpora" / "modular.jsonl").select("S1", "training", violation=True)[::40]
    scenarios = [case.scenario() for case in cases]
    arrived = {}
    for repair in ("", "modular"):
        settings = SETTINGS.model_copy(update={"policy_drives": 0, "repair": repair})
        lessons = [lesson for scenario in scenarios for lesson in lessons_of(scenario, MODEL, settings)]
        assert {lesson.repair is None for lesson in lessons} == {not repair}
        arrived[repair] = [outcome for lesson in lessons for outcome in gather(lesson).outcomes].count("GOAL")
    assert arrived["modular"] > arrived[""]


def test_what_a_cycle_keeps_goes_by_the_code_of_the_method_that_repairs_its_lessons():
    assert source_digest([few_shot.__name__, "roadmend.repair.adreft.method"]) == source_digest([few_shot.__name__])


def test_the_header_names_the_model_that_repaired_the_demonstrations(tmp_path, scenarios, gathering):
    settings = SETTINGS.model_copy(update={"keep": "last", "epochs": 1, "repair": "modular"})
    found = repair(scenarios, tmp_path / "tuned.safetensors", gathering, [], [], settings=settings)
    told = load_checkpoint(found.path, "neural").header["configuration"]["few_shot"]
    assert told["repair"] == load_checkpoint(find_model("modular", "adreft-")).digest


def test_the_replay_is_advised_by_the_expert_alone_unless_its_repair_is_asked_for():
    lessons = replay_lessons(MODEL, SETTINGS)
    assert len(lessons) == 5
    assert {lesson.repair for lesson in lessons} == {None}
    repaired = replay_lessons(MODEL, SETTINGS.model_copy(update={"replay_repair": True}))
    assert {lesson.repair for lesson in repaired} == {find_model(SETTINGS.repair, "adreft-")}
    assert [lesson.draw for lesson in repaired] == [lesson.draw for lesson in lessons]


def test_a_model_of_adreft_that_there_is_not_is_named(scenarios):
    with pytest.raises(InputError, match="ships no adreft-nobody"):
        lessons_of(scenarios[0], MODEL, SETTINGS.model_copy(update={"repair": "nobody"}))


def test_nothing_to_learn_from_and_models_of_other_kinds_are_refused(tmp_path, scenarios):
    with pytest.raises(InputError, match="none to learn from"):
        few_shot_repair(MODEL, [], SETTINGS, 0, tmp_path / "tuned.safetensors")
    other = tmp_path / "other.safetensors"
    header = {"kind": "adreft", "configuration": {}, "data_digest": "", "metrics": {}, "ancestry": []}
    save_checkpoint(other, {}, header)
    with pytest.raises(InputError, match="kind 'adreft'"):
        few_shot_repair(other, scenarios, SETTINGS, 0, tmp_path / "tuned.safetensors")


def test_the_shipped_settings_are_the_defaults_and_mistakes_in_a_file_are_named(tmp_path):
    assert read_few_shot_settings(CONFIG / "training" / "few-shot.yaml") == FewShotSettings()
    path = tmp_path / "few.yaml"
    for text, named in (
        ("epoch: 3", "epoch"),
        ("replay_share: 1.0", "replay_share"),
        ("{expert_drives: 0, policy_drives: 0}", "no demonstration"),
        ("[", "broken YAML"),
        ('{replay_repair: true, repair: ""}', "replay_repair needs a model"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=named):
            read_few_shot_settings(path)
