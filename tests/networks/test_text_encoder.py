"""The encoder of texts reads as its twin in torch does, and as any BERT with its weights would."""

import numpy as np
import pytest
import torch

from roadmend.networks.encoder import TextEncoder
from roadmend.networks.shape import TextShape
from roadmend.networks.tensors import restored, rounded
from roadmend.networks.text_encoder import TextReader

SHAPE = TextShape(pieces=50, positions=20, marks=4, hidden=24, layers=2, heads=3, feed_forward=40)
PIECES, MARKS = np.array([2, 7, 7, 49, 0, 3]), np.array([0, 1, 1, 3, 0, 2])


def network():
    torch.manual_seed(3)
    found = TextEncoder(SHAPE).eval()
    for parameter in found.parameters():
        torch.nn.init.normal_(parameter, std=0.3)
    return found


def tensors_of(found):
    return {f"encoder.{name}": value.numpy() for name, value in found.state_dict().items()}


def in_torch(found, pieces=PIECES, marks=MARKS):
    with torch.no_grad():
        pieces, marks = torch.from_numpy(pieces)[None], torch.from_numpy(marks)[None]
        return found(pieces, marks, torch.ones_like(pieces, dtype=torch.bool))[0].numpy()


def test_it_agrees_with_torch():
    found = network()
    read = TextReader(SHAPE, tensors_of(found)).read(PIECES, MARKS)
    assert read.shape == (6, 24)
    assert np.abs(read - in_torch(found)).max() < 1e-4


def test_what_is_padding_changes_nothing():
    found = network()
    longer = np.concatenate([PIECES, [5, 5]])
    with torch.no_grad():
        mask = torch.arange(8)[None] < 6
        padded = found(torch.from_numpy(longer)[None], torch.zeros(1, 8, dtype=torch.int64), mask)[0, :6].numpy()
    assert np.abs(padded - in_torch(found, PIECES, np.zeros(6, np.int64))).max() < 1e-5


def test_a_mark_is_seen_and_none_adds_nothing():
    fresh = TextEncoder(SHAPE)
    assert (fresh.marks.weight[0] == 0).all()
    found = network()
    reader = TextReader(SHAPE, tensors_of(found))
    assert np.abs(reader.read(PIECES, MARKS) - reader.read(PIECES, MARKS * 0)).max() > 0.01


def test_rounded_weights_are_a_quarter_of_the_size_and_read_nearly_the_same():
    found = network()
    whole = tensors_of(found)
    small = rounded(whole)
    assert sum(each.nbytes for each in small.values()) < 0.35 * sum(each.nbytes for each in whole.values())
    read, exact = (TextReader(SHAPE, each).read(PIECES, MARKS) for each in (restored(small), whole))
    assert 0 < np.abs(read - exact).max() < 0.1


@pytest.mark.parametrize("count", [0, 21])
def test_a_text_of_no_pieces_or_too_many_is_refused(count):
    reader = TextReader(SHAPE, tensors_of(network()))
    with pytest.raises(ValueError, match="1 to 20 wanted"):
        reader.read(np.zeros(count, np.int64), np.zeros(count, np.int64))


def test_weights_that_are_missing_of_another_shape_or_not_finite_are_refused():
    tensors = tensors_of(network())
    lacking = {name: value for name, value in tensors.items() if name != "encoder.norm.bias"}
    with pytest.raises(ValueError, match=r"encoder\.norm\.bias is missing"):
        TextReader(SHAPE, lacking)
    with pytest.raises(ValueError, match=r"shape \(24,\) wanted"):
        TextReader(SHAPE, tensors | {"encoder.norm.bias": np.zeros(3, np.float32)})
    with pytest.raises(ValueError, match="not finite"):
        TextReader(SHAPE, tensors | {"encoder.norm.bias": np.full(24, np.nan, np.float32)})


def test_a_row_of_zeros_stays_one():
    small = rounded({"a": np.zeros((2, 3), np.float32)})
    assert (restored(small)["a"] == 0).all()


def test_a_scale_that_is_missing_is_said():
    small = rounded({"a": np.ones((2, 3), np.float32)})
    del small["a.scale"]
    with pytest.raises(ValueError, match=r"a\.scale is missing"):
        restored(small)
