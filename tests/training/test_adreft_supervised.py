"""The supervised stage: it learns, an interruption changes no bit of what it learns, and it refuses another's state."""

from itertools import pairwise

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.training.adreft.configuration import ModelSection, SupervisedSection
from roadmend.training.adreft.frames import FrameSet
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.supervised import SupervisedStage
from roadmend.training.device import choose_torch_device

MODEL = ModelSection(hidden=16, layers=1, heads=2, feed_forward=16, monitor=(16,), adapter=(16,)).configuration()


@pytest.fixture(autouse=True)
def _one_thread():
    choose_torch_device("cpu", 1)


def frame_set(seed, count=400):
    """Made-up frames that are critical where some participant is near, ahead of an ego that accelerates."""
    numbers = np.random.default_rng(seed)
    sizes = numbers.integers(0, 7, count)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    tokens = numbers.uniform(-1.0, 1.0, (offsets[-1], 6)).astype(np.float32)
    action = numbers.uniform(-1.0, 1.0, count).astype(np.float32)
    near = [tokens[begin:end, 1] > 0.5 for begin, end in pairwise(offsets)]
    critical = np.array([rows.any() for rows in near]) & (action > -0.2)
    weight = np.ones(count, np.float32)
    return FrameSet(
        tokens, offsets, action, critical.astype(np.float32), weight, np.where(critical, 9, 0).astype(np.int64), weight
    )


def stage_of(state, training=None, seed=1, device="cpu", **changes):
    values = {
        "epochs": 6,
        "learning_rate": 5e-3,
        "batch": 32,
        "critical_share": 0.5,
        "frames_per_epoch": 400,
        "clip": 1.0,
    }
    section = SupervisedSection(**{**values, **changes})
    return SupervisedStage(MODEL, section, training or frame_set(0), frame_set(1), StageRun(seed, device, state))


def same(one, other):
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


class StoppedError(Exception):
    pass


def test_it_learns_what_the_labels_say(tmp_path):
    reports = []
    result = stage_of(tmp_path / "state", epochs=15).run(lambda _epoch, figures: reports.append(figures))
    first, best = reports[0], result.figures
    assert len(reports) == 15
    assert best.f1 == max(figures.f1 for figures in reports)
    assert best.f1 > first.f1 + 0.1
    assert best.loss < 0.6 * first.loss
    assert best.recall > 0.95
    assert best.accuracy > first.accuracy + 0.2


@pytest.mark.parametrize("optimizer", ["adam", "adamw"])
def test_an_interruption_changes_no_bit(tmp_path, optimizer):
    whole = stage_of(tmp_path / "whole", optimizer=optimizer, weight_decay=0.01, schedule="cosine").run()

    def stops_after(last):
        def report(epoch, _figures):
            if epoch == last:
                raise StoppedError

        return report

    for last in (1, 4):
        with pytest.raises(StoppedError):
            stage_of(tmp_path / "pieces", optimizer=optimizer, weight_decay=0.01, schedule="cosine").run(
                stops_after(last)
            )
    stage = stage_of(tmp_path / "pieces", optimizer=optimizer, weight_decay=0.01, schedule="cosine")
    assert stage.epoch == 4
    pieces = stage.run()
    assert pieces.figures == whole.figures
    assert same(pieces.tensors, whole.tensors)
    assert (tmp_path / "pieces").read_bytes() == (tmp_path / "whole").read_bytes()
    again = stage_of(tmp_path / "pieces", optimizer=optimizer, weight_decay=0.01, schedule="cosine").run()
    assert same(again.tensors, whole.tensors)


def test_the_seed_decides(tmp_path):
    results = [stage_of(tmp_path / str(number), seed=seed, epochs=2).run() for number, seed in enumerate((1, 1, 2))]
    assert same(results[0].tensors, results[1].tensors)
    assert not same(results[0].tensors, results[2].tensors)


def test_a_state_of_another_training_is_refused(tmp_path):
    stage_of(tmp_path / "state", epochs=1).run()
    for changes, name in (
        ({"seed": 2}, "seed"),
        ({"epochs": 2}, "supervised"),
        ({"training": frame_set(3)}, "training"),
        ({"device": "cpu:0"}, "device"),
    ):
        with pytest.raises(InputError, match=f"was begun with another '{name}'; start afresh"):
            stage_of(tmp_path / "state", **{"epochs": 1, **changes})


def test_a_cut_state_is_refused(tmp_path):
    stage_of(tmp_path / "state", epochs=1).run()
    (tmp_path / "state").write_bytes((tmp_path / "state").read_bytes()[:-9])
    with pytest.raises(InputError, match="cut or damaged"):
        stage_of(tmp_path / "state", epochs=1)


def test_frames_without_danger_teach_nothing(tmp_path):
    frames = frame_set(0)
    harmless = FrameSet(
        frames.tokens,
        frames.offsets,
        frames.action,
        0.0 * frames.critical,
        frames.critical_weight,
        frames.best,
        frames.best_weight,
    )
    with pytest.raises(InputError, match="training split: no frame is critical"):
        stage_of(tmp_path / "state", training=harmless)


def test_frames_of_no_weight_are_not_learned_from(tmp_path):
    """Wrong labels of weight zero do no harm."""
    frames = frame_set(0)
    wrong = np.arange(400) % 3 == 0
    critical = np.where(wrong, 1.0 - frames.critical, frames.critical).astype(np.float32)
    weight = np.where(wrong, 0.0, 1.0).astype(np.float32)
    spoilt = FrameSet(frames.tokens, frames.offsets, frames.action, critical, weight, frames.best, weight)
    result = stage_of(tmp_path / "state", training=spoilt, epochs=12, critical_share=None).run()
    assert result.figures.f1 > 0.7
