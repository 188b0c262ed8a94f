"""Nothing is driven, gathered or tuned twice, and what is decided by something else is done anew."""

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from harness import sera_kept_runs
from harness.sera_kept_runs import KeptRuns, kept_epochs
from roadmend.core.journal import Journal, entry_key
from roadmend.measures.driving import DrivingMeasures
from roadmend.networks.checkpoint import find_model, save_checkpoint
from roadmend.policies.neural_tokens import COLUMNS
from roadmend.training.few_shot import lessons_of
from roadmend.training.few_shot_settings import FewShotSettings
from roadmend.training.samples import Samples
from roadmend.world.families import sample_scenario

MODEL, OTHER = find_model("neural"), find_model("deep_sets")
SCENARIOS = [sample_scenario("S1", seed) for seed in (1, 2, 3)]
MEASURES = DrivingMeasures("COLLISION", 50.0, ("red_light", "collision_vehicle"), 21.0, False, None, 90.0, True)


@pytest.fixture
def done(monkeypatch):
    """What was really done, in order."""
    found = list[str]()

    def drive(task):
        found.append(f"drive {task[0].stem} {task[1].name}")
        return replace(MEASURES, route_completion=float(task[1].seed))

    def gather(lesson):
        found.append(f"gather {lesson.scenario.name} {lesson.model and lesson.model.stem}")
        tokens = np.full((2, COLUMNS), lesson.scenario.seed, np.float16)
        arrays = np.array([2], np.int16), np.zeros(1, np.float32), np.zeros(1, np.int8), np.zeros(1, np.int32)
        return Samples(tokens, *arrays, ("GOAL",))

    def repair(model, scenarios, settings, seed, out, *, validation, labour):
        found.append(f"tune {model.stem} {seed}")
        list(labour.gathering(lessons_of(scenarios[0], model, settings)))
        list(labour.driving(model, validation))
        header = {
            "kind": "neural",
            "configuration": {},
            "data_digest": "",
            "metrics": {"kept": {"epochs": 3}},
            "ancestry": [],
        }
        save_checkpoint(out, {}, header)

    for name, stub in (("drive_once", drive), ("gather", gather), ("few_shot_repair", repair)):
        monkeypatch.setattr(sera_kept_runs, name, stub)
    return found


def work(folder: Path, task):
    with Journal(folder / "results.jsonl", "test/1") as journal:
        return task(KeptRuns(journal, map))


def test_a_drive_is_kept_by_model_and_scenario(tmp_path, done):
    first = work(tmp_path, lambda shop: shop.drive(MODEL, SCENARIOS[:2]))
    again = work(tmp_path, lambda shop: shop.drive(MODEL, SCENARIOS[::-1]))
    assert [each.route_completion for each in again[::-1][:2]] == [each.route_completion for each in first]
    assert again[0].infractions == MEASURES.infractions
    assert len(done) == 3
    work(tmp_path, lambda shop: shop.drive(OTHER, SCENARIOS[:1]))
    assert done[3].startswith("drive deep_sets")


def test_a_lesson_is_kept_by_all_that_decides_it(tmp_path, done):
    settings = FewShotSettings(policy_drives=1)
    lessons = [lesson for scenario in SCENARIOS[:2] for lesson in lessons_of(scenario, MODEL, settings)]
    first = work(tmp_path, lambda shop: list(shop.gather(lessons)))
    assert len(done) == 4
    again = work(tmp_path, lambda shop: list(shop.gather(lessons[::-1])))
    assert len(done) == 4
    assert all((a.tokens == b.tokens).all() for a, b in zip(first, again[::-1], strict=True))
    work(tmp_path, lambda shop: list(shop.gather([replace(lessons[0], every=3), replace(lessons[0], repair=None)])))
    assert len(done) == 6


def test_a_tuned_model_is_kept_by_scenarios_settings_and_seed(tmp_path, done):
    def tune(seed=0, settings=FewShotSettings(), scenarios=SCENARIOS[:1]):  # noqa: B008 - frozen
        return work(tmp_path, lambda shop: shop.tune(MODEL, scenarios, settings, seed, SCENARIOS[2:]))

    paths = [tune(), tune(seed=1), tune(settings=FewShotSettings(epochs=1)), tune(scenarios=SCENARIOS[:2]), tune()]
    assert len(set(paths)) == 4
    assert paths[0] == paths[4]
    assert sum(each.startswith("tune") for each in done) == 4
    assert kept_epochs(paths[0]) == 3


def test_a_model_tuned_with_another_repair_of_the_same_name_is_another_one(tmp_path, done):
    repair = tmp_path / "repair.safetensors"
    paths = []
    for policy in ("modular", "neural", "modular"):
        shutil.copyfile(find_model(policy, "adreft-"), repair)
        settings = FewShotSettings(repair=str(repair))
        tune = partial(KeptRuns.tune, model=MODEL, scenarios=SCENARIOS[:1], settings=settings, seed=0)
        paths.append(work(tmp_path / "work", partial(tune, validation=SCENARIOS[2:])))
    assert paths[0] == paths[2] != paths[1]
    assert sum(each.startswith("tune") for each in done) == 2


def test_what_is_remembered_is_made_once(tmp_path):
    made, key = [], entry_key(["roadmend.core.errors"], "a")
    for _ in range(2):
        kept = work(tmp_path, lambda shop: shop.remember("x", key, lambda: made.append(1) or {"value": 7}))
        assert kept == {"value": 7}
    assert made == [1]
