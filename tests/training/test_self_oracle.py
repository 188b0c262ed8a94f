import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import save_checkpoint
from roadmend.repair.self_oracle import SelfOracleModel
from roadmend.repair.state_vector import SIZE
from roadmend.training.self_oracle import (
    SelfOracleSettings,
    fit_gamma,
    gamma_quantile,
    gather_vectors,
    train_self_oracle,
)

from .cases import Drawn

SETTINGS = SelfOracleSettings(hidden=(32, 8, 32), epochs=15, batch=64)


def nominal(cases, frames, seed=0):
    """Vectors on a four-dimensional surface."""
    numbers = np.random.default_rng(seed)
    basis = np.random.default_rng(99).normal(size=(4, SIZE))
    return [np.tanh(numbers.normal(size=(frames, 4)) @ basis).astype(np.float32) for _ in range(cases)]


@pytest.fixture(scope="module")
def trained():
    losses = []
    result = train_self_oracle(nominal(10, 100), SETTINGS, lambda _epoch, loss: losses.append(loss))
    return result, losses


def test_it_learns_and_tells_what_it_has_not_seen(trained, tmp_path):
    result, losses = trained
    assert losses[-1] < 0.5 * losses[0]
    path = tmp_path / "model.safetensors"
    save_checkpoint(path, result.tensors, result.header(SETTINGS, "0" * 64))
    model = SelfOracleModel.load(path)
    threshold = model.threshold(0.05)
    unseen = np.concatenate(nominal(2, 200, seed=1))
    assert np.mean([model.error(vector) > threshold for vector in unseen]) < 0.15
    strange = np.random.default_rng(2).normal(size=(100, SIZE)).astype(np.float32)
    assert np.mean([model.error(vector) > threshold for vector in strange]) > 0.9


def test_the_rarer_the_alarm_the_higher_the_threshold(trained):
    thresholds = trained[0].configuration.thresholds
    rates = sorted(thresholds, key=float)
    assert [thresholds[rate] for rate in rates] == sorted(thresholds.values(), reverse=True)
    assert len(set(thresholds.values())) == len(rates)


def test_the_same_data_and_seed_give_the_same_bits(trained):
    again = train_self_oracle(nominal(10, 100), SETTINGS)
    assert again.metrics == trained[0].metrics
    assert all((again.tensors[name] == trained[0].tensors[name]).all() for name in again.tensors)
    other = train_self_oracle(nominal(10, 100), SETTINGS.model_copy(update={"seed": 1}))
    assert other.metrics != again.metrics


@pytest.mark.parametrize(("shape", "scale"), [(0.5, 2.0), (3.0, 0.1), (40.0, 1.0)])
def test_the_gamma_fit_finds_the_distribution_and_its_quantiles(shape, scale):
    values = np.random.default_rng(5).gamma(shape, scale, 20_000)
    found = fit_gamma(values)
    assert found == pytest.approx((shape, scale), rel=0.05)
    for probability in (0.5, 0.95, 0.999):
        quantile = gamma_quantile(shape, scale, probability)
        point = torch.tensor([shape, quantile / scale], dtype=torch.float64)
        assert float(torch.special.gammainc(point[0], point[1])) == pytest.approx(probability, abs=1e-9)
        assert np.mean(values < quantile) == pytest.approx(probability, abs=0.01)


def test_errors_without_spread_are_refused():
    with pytest.raises(InputError):
        fit_gamma(np.full(10, 0.3))
    with pytest.raises(InputError):
        train_self_oracle(nominal(1, 10), SETTINGS)


def test_only_successes_are_learned_from():
    cases = [Drawn("S5", 3, is_violation=True), Drawn("S4", 1)]
    (vectors,) = gather_vectors(cases, "modular", 20, map)
    assert vectors.shape[1] == SIZE
    assert len(vectors) > 5
    assert np.isfinite(vectors).all()
    with pytest.raises(InputError, match="success"):
        gather_vectors(cases[:1], "modular", 20, map)
    with pytest.raises(InputError, match="does not drive it"):
        gather_vectors([Drawn("S4", 1, digest="0" * 64)], "modular", 20, map)
