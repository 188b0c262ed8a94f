"""One episode from Python: who drives, what is watched, what is recorded, and what is said when it fails."""

import json

import numpy as np
import pytest

from roadmend import EventKind, InputError, RoadmendError, run, sample_scenario
from roadmend.networks.checkpoint import find_model, load_checkpoint, save_checkpoint
from roadmend.policies.registry import make_policy
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import read_plan, recorded_result
from roadmend.recording.ticks import BagTicks
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import save_scenario


@pytest.fixture(scope="module")
def scenario():
    return sample_scenario("S3", 3).model_copy(update={"time_limit": 4.0})


def test_it_drives_as_the_runner_does_and_every_tick_is_watched(scenario, tmp_path):
    seen = []
    save_scenario(scenario, tmp_path / "s.yaml")
    result = run(tmp_path / "s.yaml", "modular", "rule", watch=lambda tick, decision, repair: seen.append(tick.number))
    assert result == run_episode(scenario, make_policy("modular"), make_repairer("rule"))
    assert seen == [*range(80)]
    assert result.outcome is EventKind.TIMEOUT


def test_the_seed_and_the_parameters_count(scenario):
    def digest(**given):
        return run(scenario, "modular", "random", **given).digest

    assert digest(seed=1) == digest(seed=1) != digest(seed=2)
    assert digest(seed=1, repair_parameters={"probability": 0.0}) == run(scenario, "modular", "none").digest


def test_a_bag_says_who_drove_and_holds_the_run(scenario, theirs, tmp_path):
    policies, repairs = theirs
    result = run(scenario, policies.Careful, repairs.Near, repair_parameters={"distance": 12.0}, bag=tmp_path / "bag")
    assert result.digest == run(scenario, policies.Careful(), repairs.Near(repairs.Settings(distance=12.0))).digest
    reader = BagReader(tmp_path / "bag")
    told = reader.metadata["roadmend"]
    assert (told["policy"], told["method"]) == (f"{policies.__name__}:Careful", f"{repairs.__name__}:Near")
    assert json.loads(told["method_parameters"]) == {"distance": 12.0}
    assert told["policy_origin"] == policies.__file__
    assert len(told["method_code_sha256"]) == 64
    assert told["outcome"] == "TIMEOUT"
    plan = read_plan(reader, told["policy"])
    assert plan.scenario == scenario
    assert recorded_result(BagTicks(reader), plan).digest == result.digest


def test_numbers_of_numpy_are_numbers_in_the_bag_too(scenario, theirs, tmp_path):
    _, repairs = theirs
    run(scenario, "modular", repairs.Near, repair_parameters={"distance": np.float32(12.5)}, bag=tmp_path / "bag")
    told = BagReader(tmp_path / "bag").metadata["roadmend"]
    assert json.loads(told["method_parameters"]) == {"distance": 12.5}


def test_of_an_object_the_bag_tells_no_defaults(scenario, theirs, tmp_path):
    _, repairs = theirs
    run(scenario, "modular", repairs.Near(repairs.Settings(distance=12.0)), bag=tmp_path / "bag")
    told = BagReader(tmp_path / "bag").metadata["roadmend"]
    assert "method_parameters" not in told
    assert told["method_origin"] == repairs.__file__
    assert len(told["method_code_sha256"]) == 64
    assert "policy_parameters" in told
    assert told["policy_class"] == "roadmend.policies.modular.ModularPolicy"


def test_an_object_whose_class_wants_more_than_parameters_says_who_drove(scenario, theirs, tmp_path):
    policies, _ = theirs

    class Fast(policies.Careful):
        def __init__(self, pace):
            self.pace = pace

    Fast.__module__, Fast.__qualname__ = policies.__name__, "Fast"
    run(scenario, Fast(3.0), "none", bag=tmp_path / "bag")
    told = BagReader(tmp_path / "bag").metadata["roadmend"]
    assert told["policy"] == f"{policies.__name__}:Fast"
    assert told["policy_class"] == f"{policies.__name__}.Fast"
    assert told["policy_origin"] == policies.__file__
    assert len(told["policy_code_sha256"]) == 64
    assert "policy_parameters" not in told


def test_a_model_among_the_parameters_has_settings_of_its_own(scenario, tmp_path):
    neural = load_checkpoint(find_model("neural"))
    tensors = {name: array.copy() for name, array in neural.tensors.items()}
    next(iter(tensors.values()))[...] += 1e-3
    header = {name: value for name, value in neural.header.items() if name != "format"}
    save_checkpoint(tmp_path / "other.safetensors", tensors, header)
    model = str(tmp_path / "other.safetensors")

    def settings(policy, **given):
        run(scenario, policy, "rss", bag=tmp_path / f"bag{len([*tmp_path.iterdir()])}", **given)
        [*_, newest] = sorted(tmp_path.glob("bag*"))
        return json.loads(BagReader(newest).metadata["roadmend"]["method_parameters"])

    shipped = settings("neural")
    assert settings("neural", policy_parameters={"model": "neural"}) == shipped
    assert settings(model) == settings("neural", policy_parameters={"model": model}) != shipped


def test_what_fails_on_the_way_is_one_line_and_leaves_no_bag(scenario, theirs, tmp_path):
    policies, repairs = theirs
    with pytest.raises(RoadmendError, match=r"^policy .*Late: failed in step at 1.05 s: ZeroDivisionError"):
        run(scenario, policies.Late, bag=tmp_path / "bag")
    assert not (tmp_path / "bag").exists()
    with pytest.raises(RoadmendError, match=r"Late failed: .*KeyError"):
        run(scenario, "modular", repairs.Late, bag=tmp_path / "bag")
    assert not (tmp_path / "bag").exists()
    assert run(scenario, policies.Careful, "none").ticks == 80  # SUMO is free again


def test_what_is_no_scenario_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        run(tmp_path / "gone.yaml")
    with pytest.raises(InputError, match="is neither a Scenario nor a path, but int"):
        run(3)


def test_numbers_of_numpy_are_seeds(scenario):
    assert run(scenario, repair="random", seed=np.int64(3)) == run(scenario, repair="random", seed=3)


@pytest.mark.parametrize("name", ["policy_parameters", "repair_parameters"])
def test_parameters_that_have_no_names_are_refused(scenario, name):
    with pytest.raises(InputError, match=f"{name}: is no dictionary of values by name, but int"):
        run(scenario, **{name: 5})


@pytest.mark.parametrize("seed", ["x", 1.5, -1, True, None])
def test_what_is_no_seed_is_refused(scenario, seed):
    with pytest.raises(InputError, match=r"^seed: .* is no whole number from 0; give for instance 7$"):
        run(scenario, repair="random", seed=seed)
