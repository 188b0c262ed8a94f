"""Practice on futures: weights by hand, chances learned from made-up moments, an interruption that changes no bit."""

import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER, Weighing
from roadmend.training.adreft.case_moments import CaseMoments
from roadmend.training.adreft.configuration import ModelSection, PracticeSection
from roadmend.training.adreft.futures_stage import FuturesStage
from roadmend.training.adreft.moment_set import MomentSet
from roadmend.training.adreft.scoring import monitor_scores
from roadmend.training.adreft.stage import StageRun
from roadmend.training.device import choose_torch_device

MODEL = ModelSection(
    hidden=16, layers=1, heads=2, feed_forward=16, monitor=(16,), adapter=(16,), weighing=Weighing()
).configuration()
NONE = float("nan")


@pytest.fixture(autouse=True)
def _one_thread():
    choose_torch_device("cpu", 1)


def moments_of(danger, tried=(), attribute=0.0, *, violates=False, span=1.0):
    """Moments that have one token each; ``tried`` has moment, choice, averted, caused and futures behind both."""
    count = len(danger)
    tokens = np.zeros((count, 6), dtype=np.float16)
    tokens[:, 0], tokens[:, 1] = 1.0, attribute
    columns = list(zip(*tried, strict=True)) if tried else [()] * 6
    kinds = (np.int32, np.int8, np.float32, np.float32, np.int32, np.int32)
    return CaseMoments(
        "case",
        violates,
        4,
        0.2 * np.arange(count),
        np.full(count, span, dtype=np.float32),
        np.full(count, 0.5, dtype=np.float32),
        np.array(danger, dtype=np.float32),
        np.ones(count, dtype=np.int32),
        tokens,
        *(np.array(column, dtype=kind) for column, kind in zip(columns, kinds, strict=True)),
    )


def test_moments_weigh_the_time_that_they_stand_for_and_violations_as_they_occur():
    violation = moments_of([1.0, 0.5], violates=True, span=2.0)
    harmless = moments_of([0.0] * 3, span=4.0)
    found = MomentSet.join([violation, harmless, violation], 0.25, 1.0)
    # One harmless case in three: two violations weigh 1/6 each of what it weighs, to be a quarter of the cases.
    plain = np.array([2.0 / 6.0] * 2 + [4.0] * 3 + [2.0 / 6.0] * 2)
    np.testing.assert_allclose(found.judged, plain / plain.mean(), rtol=1e-6)
    assert found.critical.tolist() == [1.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0.5]
    np.testing.assert_allclose(MomentSet.join([violation, harmless], 0.25, 0.0).judged, np.ones(5))
    rooted = MomentSet.join([violation, harmless, violation], 0.25, 0.5).judged
    np.testing.assert_allclose(rooted, np.sqrt(plain) / np.sqrt(plain).mean(), rtol=1e-6)
    alone = MomentSet.join([violation], 0.25, 1.0)
    np.testing.assert_allclose(alone.judged, np.ones(2))


def test_what_was_tried_stands_in_its_place():
    first = moments_of([0.5, 0.0], [(0, 9, 0.5, 0.0, 2, 2), (1, 3, NONE, 0.25, 0, 4)])
    found = MomentSet.join([first, moments_of([1.0], [(0, 9, 1.0, NONE, 4, 0)])], 0.1, 1.0)
    expected = np.zeros((4, 3, 10), dtype=np.float32)
    expected[0, [0, 2], 9], expected[1, [0, 2], 9] = (0.5, 1.0), (2, 4)
    expected[2, 1, 3], expected[3, [0, 1], [9, 3]] = 0.25, (2, 4)
    np.testing.assert_array_equal([found.averted, found.averted_of, found.caused, found.caused_of], expected)
    assert found.digest != MomentSet.join([first], 0.1, 1.0).digest


def worlds():
    """Where the attribute is 1 the policy violates in 3 of 4 futures, and braking averts half; where it is 0, nothing."""
    hot = moments_of([0.75] * 4, [(0, 9, 0.5, NONE, 3, 0), (1, 9, 0.5, NONE, 3, 0)], 1.0, violates=True)
    cold = moments_of([0.0] * 4, [(0, 9, NONE, 0.0, 0, 4)], 0.0)
    return MomentSet.join([hot] * 20 + [cold] * 20, 0.5, 1.0)


def stage_of(tmp_path, epochs, state="state.safetensors", moments=None, start=None):
    section = PracticeSection(epochs=epochs, method="futures", batch=32, learning_rate=1e-2, dropout=0.1)
    run = StageRun(3, "cpu", tmp_path / state)
    return FuturesStage(MODEL, section, worlds() if moments is None else moments, run, start)


def test_chances_are_learned(tmp_path):
    stage = stage_of(tmp_path, 30)
    tensors = stage.run()
    tokens = np.zeros((2, 1, 6), dtype=np.float32)
    tokens[:, 0, 0], tokens[1, 0, 1] = 1.0, 1.0
    network = stage.network.eval()
    with torch.no_grad():
        logits, outputs = network(torch.from_numpy(tokens), torch.ones(2, 1, dtype=torch.bool), torch.full((2,), 0.5))
    chances, scores = torch.sigmoid(outputs).numpy(), torch.sigmoid(logits).numpy()
    assert scores == pytest.approx([0.0, 0.75], abs=0.1)
    assert chances[:, DANGER] == pytest.approx([0.0, 0.75], abs=0.1)
    assert chances[1, AVERTED][9] == pytest.approx(0.5, abs=0.1)
    assert chances[0, CAUSED][9] < 0.1
    moments = worlds()
    found = monitor_scores(MODEL, tensors, moments, moments.action, map)
    np.testing.assert_allclose(found, np.where(moments.critical > 0.0, scores[1], scores[0]), atol=1e-4)


def test_an_interruption_changes_no_bit_and_a_start_does(tmp_path):
    whole = stage_of(tmp_path, 4, "whole.safetensors").run()

    def stop(figures):
        if figures.epoch == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stage_of(tmp_path, 4, "parts.safetensors").run(stop)
    parts = stage_of(tmp_path, 4, "parts.safetensors").run()
    assert all(np.array_equal(whole[name], parts[name]) for name in whole)
    further = stage_of(tmp_path, 4, "further.safetensors", start=whole).run()
    assert any(not np.array_equal(whole[name], further[name]) for name in whole)


def test_a_state_is_not_gone_on_with_from_another_start(tmp_path):
    first = stage_of(tmp_path, 1, "first.safetensors").run()
    second = stage_of(tmp_path, 2, "second.safetensors").run()
    begun = stage_of(tmp_path, 2, start=first).run()
    again = stage_of(tmp_path, 2, start=first).run()
    assert all(np.array_equal(begun[name], again[name]) for name in begun)
    for other in (second, None):
        with pytest.raises(InputError, match="was begun with another 'start'"):
            stage_of(tmp_path, 2, start=other)


def test_a_batch_of_little_weight_counts_little(tmp_path):
    moments = worlds()
    stage = stage_of(tmp_path, 1, moments=moments)
    logits = torch.zeros(4)
    heavy, light = np.flatnonzero(moments.critical > 0.0)[:4], np.flatnonzero(moments.critical == 0.0)[:4]
    expected = np.log(2.0) * moments.judged[[heavy[0], light[0]]]
    found = [stage._monitor_loss(logits, chosen).item() for chosen in (heavy, light)]
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_moments_at_which_nothing_was_tried_are_refused(tmp_path):
    with pytest.raises(InputError, match="something was tried"):
        stage_of(tmp_path, 1, moments=MomentSet.join([moments_of([0.0, 0.5])], 0.1, 1.0))
