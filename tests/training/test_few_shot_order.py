"""One order of few-shot repair, and the mean of several."""

import numpy as np
import pytest
import torch

from roadmend.learning.checkpoint import load_checkpoint
from roadmend.learning.shipped import find_model
from roadmend.training.few_shot_order import Epoch, Order, mean_of, tune
from roadmend.training.few_shot_settings import FewShotSettings
from roadmend.training.imitation_rollout import gather, ordinary_lesson

MODEL = find_model("deep_sets")
SETTINGS = FewShotSettings(epochs=2, learning_rate=1e-3)


@pytest.fixture(scope="module")
def lessons():
    return [gather(ordinary_lesson("S3", seed, None, 1.0, 0.0, 20)) for seed in (240_300, 240_301)]


def test_every_epoch_moves_the_weights_and_an_order_repeats(lessons):
    shown, old = lessons
    first, again, other = (tune(Order(MODEL, SETTINGS, shown, old, 1, number)) for number in (0, 0, 1))
    before = load_checkpoint(MODEL).tensors
    for one, two in ((before, first[0].tensors), (first[0].tensors, first[1].tensors)):
        assert any((one[name] != two[name]).any() for name in one)
    assert [epoch.loss for epoch in first] == [epoch.loss for epoch in again]
    assert all((first[1].tensors[name] == again[1].tensors[name]).all() for name in before)
    assert any((first[1].tensors[name] != other[1].tensors[name]).any() for name in before)


def test_the_number_of_threads_is_given_back(lessons):
    threads = torch.get_num_threads()
    tune(Order(MODEL, SETTINGS.model_copy(update={"epochs": 1}), lessons[0], None, 1, 0))
    assert torch.get_num_threads() == threads


def test_the_mean_is_that_of_the_weights_after_the_same_epoch():
    orders = [
        [Epoch({"a": np.full(2, value + epoch, np.float32)}, value) for epoch in range(2)] for value in (1.0, 4.0)
    ]
    means = [*mean_of(orders)]
    assert [each.tensors["a"].tolist() for each in means] == [[2.5, 2.5], [3.5, 3.5]]
    assert [each.loss for each in means] == [2.5, 2.5]
    assert means[0].tensors["a"].dtype == np.float32
