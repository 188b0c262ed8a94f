import numpy as np
import pytest

from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.weighing import DANGER, Weighing
from roadmend.training.adreft.configuration import ModelSection
from roadmend.training.adreft.network import AdreftNetwork
from roadmend.training.adreft.recalibration import fit_logits, fold, sigmoids
from roadmend.training.torch_state import tensors_of


@pytest.mark.parametrize(("slope", "offset"), [(1.0, 0.0), (0.4, -2.0), (2.5, 1.0)])
def test_slope_and_offset_are_found(slope, offset):
    logits = np.random.default_rng(1).normal(0.0, 2.0, 4000)
    found = fit_logits(logits, sigmoids(slope * logits + offset), np.ones(4000))
    assert found == pytest.approx((slope, offset), rel=0.1, abs=0.05)


def test_the_order_is_never_turned_and_little_is_changed_where_little_is_known():
    logits = np.linspace(-3.0, 3.0, 50)
    assert fit_logits(logits, sigmoids(-logits), np.ones(50))[0] == pytest.approx(0.05)
    slope, offset = fit_logits(np.full(3, 30.0), np.zeros(3), np.ones(3))
    assert np.isfinite([slope, offset]).all()
    assert slope > 0.0


def test_folded_into_the_last_layers_only_score_and_danger_change():
    model = ModelSection(hidden=8, layers=1, heads=2, feed_forward=8, monitor=(4,), adapter=(4,), weighing=Weighing())
    configuration = model.configuration()
    tensors = tensors_of(AdreftNetwork(configuration))
    before = AdreftModel(configuration, tensors, 0.5)
    after = AdreftModel(configuration, fold(configuration, tensors, (0.5, -1.0), (2.0, 0.3)), 0.5)
    state = before.encode(np.ones((3, 6), dtype=np.float32))
    score = before.score(state, 0.4)
    logit = np.log(score / (1.0 - score))
    assert after.score(state, 0.4) == pytest.approx(float(sigmoids(np.array(0.5 * logit - 1.0))), rel=1e-4)
    expected = np.array(before.given(state))
    expected[DANGER] = 2.0 * expected[DANGER] + 0.3
    np.testing.assert_allclose(after.given(state), expected, rtol=1e-5)
