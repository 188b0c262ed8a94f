"""The compiled twins of the encoders that are no transformers agree with torch, and hide nothing that is not finite."""

import numpy as np
import pytest
import torch

from roadmend.networks.compiled_set import CompiledExcerpt, CompiledSetEncoder
from roadmend.networks.encoder import Excerpt, SetEncoder
from roadmend.networks.shape import ExcerptShape, SetShape

SET = SetShape(attributes=6, hidden=(9, 7), outputs=5)
EXCERPT = ExcerptShape(attributes=6, places=((0, 1), (0, 4), (2, 5)))


@pytest.fixture
def pair():
    torch.manual_seed(1)
    network = SetEncoder(SET).eval()
    tensors = {f"encoder.{name}": value.numpy() for name, value in network.state_dict().items()}
    return network, CompiledSetEncoder(SET, tensors)


def draw(count):
    return np.random.default_rng(count).normal(size=(count, 6)).astype(np.float32)


@pytest.mark.parametrize("count", [1, 2, 30])
def test_a_set_agrees_with_torch_and_does_not_see_its_padding(pair, count):
    network, twin = pair
    tokens = draw(count)
    padded = np.concatenate([tokens, np.full((3, 6), 50.0, np.float32)])
    mask = torch.arange(count + 3)[None] < count
    with torch.no_grad():
        expected = network(torch.from_numpy(padded)[None], mask)[0].numpy()
    assert twin.encode(tokens).shape == (SET.state,)
    np.testing.assert_allclose(twin.encode(tokens), expected, rtol=0, atol=2e-6)


def test_the_order_of_the_others_does_not_matter_but_the_first_is_the_ego(pair):
    _, twin = pair
    tokens = draw(8)
    state = twin.encode(tokens)
    assert (twin.encode(tokens[[0, *range(7, 0, -1)]]) == state).all()
    assert (twin.encode(tokens[::-1]) != state).any()


@pytest.mark.parametrize("place", [0, 3])
def test_what_is_not_finite_in_any_token_reaches_the_state(pair, place):
    _, twin = pair
    tokens = draw(5)
    tokens[place, 2] = np.nan
    assert np.isnan(twin.encode(tokens)).any()


@pytest.mark.parametrize("shape", [(0, 6), (3, 5), (6,)])
def test_tokens_of_another_shape_are_refused(pair, shape):
    with pytest.raises(ValueError, match="tokens"):
        pair[1].encode(np.zeros(shape, np.float32))


def test_an_excerpt_is_what_it_names_and_no_more():
    tokens = draw(4)
    twin = CompiledExcerpt(EXCERPT, {})
    expected = Excerpt(EXCERPT)(torch.from_numpy(tokens)[None], torch.ones(1, 4, dtype=torch.bool))[0].numpy()
    assert (twin.encode(tokens) == expected).all()
    others = tokens.copy()
    others[3] = 9.0
    others[0, 0] = 9.0
    assert (twin.encode(others) == expected).all()
    with pytest.raises(ValueError, match="at least 3"):
        twin.encode(tokens[:2])
