"""The networks in torch: sets in, states out."""

import pytest
import torch
from pydantic import ValidationError

from roadmend.networks.encoder import EncoderLayer, Head, SceneEncoder
from roadmend.networks.shape import EncoderShape, HeadShape

SHAPE = EncoderShape(attributes=6, hidden=24, layers=3, heads=3, feed_forward=40)


@pytest.fixture
def encoder():
    torch.manual_seed(1)
    return SceneEncoder(SHAPE).eval()


@pytest.fixture
def tokens():
    return torch.randn(2, 9, 6, generator=torch.Generator().manual_seed(2))


def everything(tokens):
    return torch.ones(tokens.shape[:2], dtype=torch.bool)


def test_padding_does_not_change_a_state(encoder, tokens):
    mask = everything(tokens)
    mask[1, 5:] = False
    state = encoder(tokens, mask)
    assert state.shape == (2, 24)
    alone = encoder(tokens[1:, :5], everything(tokens[1:, :5]))
    torch.testing.assert_close(state[1:], alone, rtol=0, atol=1e-6)
    changed = tokens.clone()
    changed[1, 5:] = 1e3
    torch.testing.assert_close(encoder(changed, mask), state, rtol=0, atol=0)


def test_the_order_of_the_tokens_does_not_matter(encoder, tokens):
    turned = tokens.flip(1)
    torch.testing.assert_close(encoder(turned, everything(turned)), encoder(tokens, everything(tokens)))


def test_a_scene_of_nothing_has_a_state(encoder):
    nothing = torch.zeros(1, 0, 6)
    state = encoder(nothing, everything(nothing))
    assert state.shape == (1, 24)
    assert state.isfinite().all()


def test_the_short_cut_of_the_last_layer_changes_nothing(tokens):
    layer = EncoderLayer(EncoderShape(attributes=6, hidden=6, heads=2, feed_forward=7, activation="gelu"))
    mask = everything(tokens)[:, None, None, :]
    torch.testing.assert_close(layer(tokens, mask, first_only=True), layer(tokens, mask)[:, :1])


def test_a_layer_computes_what_torchs_own_does(tokens):
    shape = EncoderShape(attributes=6, hidden=6, heads=2, feed_forward=7)
    ours = EncoderLayer(shape).eval()
    theirs = torch.nn.TransformerEncoderLayer(6, 2, 7, dropout=0.0, batch_first=True).eval()
    names = {
        "attention_in.weight": "self_attn.in_proj_weight",
        "attention_in.bias": "self_attn.in_proj_bias",
        "attention_out": "self_attn.out_proj",
        "feed_in": "linear1",
        "feed_out": "linear2",
        "norm1": "norm1",
        "norm2": "norm2",
    }
    for parameter in ours.parameters():
        torch.nn.init.normal_(parameter)
    weights = {}
    for name, value in ours.state_dict().items():
        part, _, kind = name.rpartition(".")
        weights[names.get(name) or f"{names[part]}.{kind}"] = value
    theirs.load_state_dict(weights)
    torch.testing.assert_close(ours(tokens, everything(tokens)[:, None, None, :]), theirs(tokens))


def test_every_parameter_learns(encoder, tokens):
    head = Head(HeadShape(inputs=24, hidden=(5,), outputs=2))
    head(encoder(tokens, everything(tokens))).square().sum().backward()
    for name, parameter in [*encoder.named_parameters(), *head.named_parameters()]:
        assert parameter.grad is not None, name
        if name != "layers.2.attention_in.bias":  # the softmax does not see the bias of the keys
            assert parameter.grad.abs().sum() > 0, name


def test_a_head_without_hidden_layers_is_a_linear_map():
    head = Head(HeadShape(inputs=3, hidden=(), outputs=2))
    x, y = torch.randn(3), torch.randn(3)
    torch.testing.assert_close(head(x) + head(y), head(x + y) + head(torch.zeros(3)))


@pytest.mark.parametrize("change", [{"heads": 5}, {"hidden": 0}, {"activation": "tanh"}, {"layers": 0}, {"width": 3}])
def test_impossible_shapes_are_refused(change):
    with pytest.raises(ValidationError):
        EncoderShape(**{**SHAPE.model_dump(), **change})
