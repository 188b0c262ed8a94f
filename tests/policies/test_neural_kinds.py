"""What every kind of neural policy shares, and what the ego perceptron must not see."""

import json

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import find_model, load_checkpoint, models_folder, save_checkpoint
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.registry import make_policy
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode

from .proving_ground import Body, drive, road
from .test_completion import Unrepaired


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_kind_ships_a_small_model_that_drives_the_same_again(kind):
    scenario = sample_scenario("S2", 61_000).model_copy(update={"time_limit": 6.0})
    runs = [run_episode(scenario, make_policy(kind), Unrepaired()) for _ in range(2)]
    assert runs[0].digest == runs[1].digest
    assert runs[0].is_finite
    assert find_model(kind).stat().st_size < 1_000_000


def test_all_shipped_models_that_drive_or_repair_are_small_together_and_so_is_the_one_that_reads():
    sizes = {path.stem: path.stat().st_size for path in models_folder().rglob("*.safetensors")}
    assert sizes.pop("crash-text") < 20_000_000
    assert sum(sizes.values()) < 20_000_000


def test_the_ego_perceptron_sees_nobody_and_the_set_does():
    body = Body(1, 150.0, 0.0)
    for kind, sees in (("ego_mlp", False), ("deep_sets", True)):
        alone = drive(make_policy(kind), road(), 15.0, 5.0, 12.0)
        behind = drive(make_policy(kind), road(), 15.0, 5.0, 12.0, [body])
        assert (alone.x != behind.x) == sees


def test_a_model_of_another_kind_is_refused():
    with pytest.raises(InputError, match="kind 'neural'"):
        make_policy("deep_sets", {"model": str(find_model("neural"))})


@pytest.mark.parametrize(("part", "name"), [("encoder", "attributes"), ("head", "inputs")])
def test_a_model_of_other_tokens_is_refused(tmp_path, part, name):
    shipped = load_checkpoint(find_model("deep_sets"))
    header = json.loads(json.dumps(shipped.header))
    header["configuration"][part][name] += 1
    path = tmp_path / "other.safetensors"
    save_checkpoint(path, shipped.tensors, header)
    with pytest.raises(InputError, match="trained on other tokens"):
        make_policy("deep_sets", {"model": str(path)})


@pytest.mark.parametrize("place", [[0, 86], [0, -1], [-1, 3], [5, 3]])
def test_a_perceptron_of_places_that_no_scene_need_have_is_refused(tmp_path, place):
    shipped = load_checkpoint(find_model("ego_mlp"))
    header = json.loads(json.dumps(shipped.header))
    header["configuration"]["encoder"]["places"][-1] = place
    path = tmp_path / "other.safetensors"
    save_checkpoint(path, shipped.tensors, header)
    with pytest.raises(InputError, match="trained on other tokens"):
        make_policy("ego_mlp", {"model": str(path)})


def test_weights_that_are_not_finite_are_refused(tmp_path):
    shipped = load_checkpoint(find_model("ego_mlp"))
    tensors = {name: np.full_like(array, np.nan) for name, array in shipped.tensors.items()}
    path = tmp_path / "broken.safetensors"
    save_checkpoint(path, tensors, shipped.header)
    with pytest.raises(InputError, match="not finite"):
        make_policy("ego_mlp", {"model": str(path)})
