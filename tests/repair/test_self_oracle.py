import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import save_checkpoint
from roadmend.networks.shape import HeadShape
from roadmend.repair.parameters import ModelParameters
from roadmend.repair.registry import make_repairer
from roadmend.repair.self_oracle import Configuration, ModelRepair, SelfOracleModel
from roadmend.repair.state_vector import SIZE, VERSION, state_vector

from .playground import Box, keep_on, scene_of, straight_route

SHAPE = HeadShape(inputs=SIZE, hidden=(), outputs=SIZE)
SCENE = scene_of([Box(1, 15.0, 1.0, speed=4.0)])
DECISION = keep_on(SCENE)


def tensors_that_know(vector):
    """A linear map that gives ``vector`` whatever comes in, so that the error is the distance to it."""
    return {
        "autoencoder.layers.0.weight": np.zeros((SIZE, SIZE), np.float32),
        "autoencoder.layers.0.bias": vector,
        "mean": np.zeros(SIZE, np.float32),
        "scale": np.ones(SIZE, np.float32),
    }


def model_that_knows(vector, threshold=1e-6):
    configuration = Configuration(vector_version=VERSION, autoencoder=SHAPE, thresholds={"0.05": threshold})
    return SelfOracleModel(configuration, tensors_that_know(vector))


def saved(path, **changes):
    configuration = {
        "vector_version": VERSION,
        "autoencoder": SHAPE.model_dump(mode="json"),
        "thresholds": {"0.05": 1e-6, "0.01": 0.5},
    } | changes
    header = {"kind": "self_oracle", "configuration": {"model": configuration}, "data_digest": "", "metrics": {}}
    save_checkpoint(path, tensors_that_know(state_vector(SCENE, DECISION)), header | {"ancestry": []})
    return path


def test_what_is_familiar_passes_and_what_is_not_is_braked_for():
    method = ModelRepair(ModelParameters(), model_that_knows(state_vector(SCENE, DECISION)))
    method.reset(straight_route())
    familiar = method.propose(SCENE, DECISION)
    assert familiar.score == 0.0
    strange_scene = scene_of([Box(1, 15.0, 1.0, speed=4.0), Box(2, 3.0, -2.0)])
    strange = method.propose(strange_scene, keep_on(strange_scene))
    assert strange.score > strange.threshold == familiar.threshold
    assert strange.action == -1.0
    assert "unfamiliar" in strange.reason


def test_the_error_is_the_mean_square_of_what_was_not_rebuilt():
    model = model_that_knows(np.zeros(SIZE, np.float32))
    vector = np.zeros(SIZE, np.float32)
    vector[4], vector[7] = 2.0, 100.0
    assert model.error(vector) == pytest.approx((2.0**2 + 5.0**2) / SIZE)  # clipped at 5 standard deviations


def test_it_works_from_a_file_behind_the_guard(tmp_path):
    path = saved(tmp_path / "model.safetensors")
    repairer = make_repairer("model", {"model": str(path)})
    repairer.reset(straight_route())
    assert not repairer.step(SCENE, DECISION).intervened
    strange = scene_of([Box(1, 15.0, 1.0, speed=4.0), Box(2, 3.0, -2.0)], time=0.05)
    assert repairer.step(strange, keep_on(strange)).final_action == -1.0
    mild = make_repairer("model", {"model": str(path), "false_alarm_rate": 0.01})
    mild.reset(straight_route())
    assert mild.step(strange, keep_on(strange)).threshold == 0.5


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"model": "no/such.safetensors"}, "no such model file"),
        ({"model": "nobody"}, "self_oracle-nobody"),
        ({"false_alarm_rate": 0.06}, "choose one of: 0.01, 0.05"),
        ({"false_alarm_rate": 1.0}, "false_alarm_rate"),
    ],
)
def test_what_cannot_be_loaded_is_an_input_error(tmp_path, parameters, words):
    given = {"model": str(saved(tmp_path / "model.safetensors"))} | parameters
    with pytest.raises(InputError, match=words):
        make_repairer("model", given)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vector_version": VERSION + 1}, "state vector"),
        ({"thresholds": None}, "configuration"),
        ({"autoencoder": {"inputs": SIZE, "hidden": [3], "outputs": SIZE}}, "shape"),
    ],
)
def test_a_model_that_does_not_fit_is_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        SelfOracleModel.load(saved(tmp_path / "model.safetensors", **changes))
