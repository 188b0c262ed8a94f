"""A risk monitor learns what tells ticks that end badly from the others, and how sure it must be."""

import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.measures.monitor import separation_of
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.risk_monitor import RiskConfiguration, RiskMonitor
from roadmend.training.adreft.case_risks import CaseRisks
from roadmend.training.adreft.risk_learning import learn_risks, risks_of, threshold_by_drives, threshold_by_ticks
from roadmend.training.adreft.risk_settings import NeedSettings

SHIPPED = find_model("modular", "adreft-")


def case_of(collided):
    collided = np.array(collided, np.float32)
    return CaseRisks("", np.ones(len(collided), np.int32), np.zeros((len(collided), 2), np.float16), collided)


def test_it_learns_what_tells_bad_ticks_from_good_ones():
    start = load_checkpoint(SHIPPED).tensors
    encoder = AdreftModel.load(SHIPPED).configuration.encoder
    numbers = np.random.default_rng(0)
    collided = (numbers.random(300) < 0.3).astype(np.float32)
    tokens = numbers.normal(0.0, 0.3, (300, 2, encoder.attributes))
    tokens[:, 1, 0] += 2.0 * collided
    cases = [CaseRisks("all", np.full(300, 2, np.int32), tokens.reshape(600, -1).astype(np.float16), collided)]
    settings = NeedSettings(epochs=3, batch=16)
    shape = RiskConfiguration(encoder=encoder, threshold=0.5, horizon=8.0)
    told = []
    tensors = learn_risks(shape, settings, cases, start, "need.", 0, lambda *each: told.append(each))
    assert [epoch for epoch, _ in told] == [1, 2, 3]
    assert all(name.startswith("need.") for name in tensors)
    assert separation_of(risks_of(RiskMonitor(shape, tensors, "need."), cases), collided > 0.5) > 0.9
    again = learn_risks(shape, settings, cases, start, "need.", 0)
    assert all(np.array_equal(tensors[name], again[name]) for name in tensors)


def test_it_learns_the_same_on_a_machine_of_more_cores():
    start = load_checkpoint(SHIPPED).tensors
    encoder = AdreftModel.load(SHIPPED).configuration.encoder
    numbers = np.random.default_rng(0)
    tokens = numbers.standard_normal((64 * 20, encoder.attributes)).astype(np.float16)
    cases = [CaseRisks("all", np.full(64, 20, np.int32), tokens, (numbers.random(64) < 0.3).astype(np.float32))]
    shape, before = RiskConfiguration(encoder=encoder, threshold=0.5, horizon=8.0), torch.get_num_threads()
    learned = []
    try:
        for threads in (1, 4):
            torch.set_num_threads(threads)
            learned.append(learn_risks(shape, NeedSettings(epochs=1), cases, start, "need.", 0))
            assert torch.get_num_threads() == threads
    finally:
        torch.set_num_threads(before)
    assert all(np.array_equal(learned[0][name], learned[1][name]) for name in learned[0])


def test_false_alarms_are_a_share_of_the_harmless_ticks():
    risks, cases = np.array([0.1, 0.2, 0.3, 0.4, 0.9, 0.35]), [case_of([0, 0, 0]), case_of([0, 1, 1])]
    assert np.mean(risks[:4] > threshold_by_ticks(risks, cases, 0.25)) == 0.25


def test_false_alarms_are_a_share_of_the_harmless_drives():
    cases = [case_of([0, 0]), case_of([]), case_of([0]), case_of([0, 1]), case_of([0, 0, 0])]
    risks = np.array([0.1, 0.8, 0.2, 0.9, 0.95, 0.3, 0.6, 0.3])
    threshold = threshold_by_drives(risks, cases, 0.5)  # the worst of the harmless drives: 0.8, none, 0.2, 0.6
    assert threshold == pytest.approx(0.4)


def test_where_every_drive_ends_badly_there_is_no_threshold():
    with pytest.raises(InputError, match="all end badly"):
        threshold_by_drives(np.array([0.2, 0.9]), [case_of([0, 1])], 0.3)
