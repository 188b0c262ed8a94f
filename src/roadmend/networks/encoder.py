"""The networks in torch, for training; they drive as their compiled twins (roadmend.networks.compiled_encoder)."""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from roadmend.networks.shape import EncoderShape, ExcerptShape, HeadShape, SetShape, TextShape


class EncoderLayer(nn.Module):
    """Self-attention, then two linear maps on each token; each with a residual and a layer norm behind it (post-norm).

    Args:
        shape: of the encoder that it is part of.
        dropout: share of the values that training drops behind the attention and behind the linear maps.

    Source: Vaswani et al. 2017, section 3.1, as in BERT (Devlin et al. 2019).
    """

    def __init__(self, shape: EncoderShape, dropout: float = 0.0) -> None:
        super().__init__()
        self.heads = shape.heads
        self.drop = nn.Dropout(dropout)
        self.gelu = shape.activation == "gelu"
        # Queries, keys and values in this order, in one map.
        self.attention_in = nn.Linear(shape.hidden, 3 * shape.hidden)
        self.attention_out = nn.Linear(shape.hidden, shape.hidden)
        self.norm1 = nn.LayerNorm(shape.hidden)
        self.feed_in = nn.Linear(shape.hidden, shape.feed_forward)
        self.feed_out = nn.Linear(shape.feed_forward, shape.hidden)
        self.norm2 = nn.LayerNorm(shape.hidden)
        for part in self.attention_in.weight.chunk(3):
            nn.init.xavier_uniform_(part)
        nn.init.zeros_(self.attention_in.bias)
        nn.init.zeros_(self.attention_out.bias)

    def forward(self, tokens: Tensor, mask: Tensor, *, first_only: bool = False) -> Tensor:
        """Transform (B, T, H) into (B, T, H), or into (B, 1, H) where only the first token is wanted.

        Args:
            tokens: (B, T, H) float32.
            mask: (B, 1, 1, T) bool, True where a token is real.
            first_only: what the last layer need do: the first token looks at all, nobody else at anything.
        """
        wanted = tokens[:, :1] if first_only else tokens
        weight, bias = self.attention_in.weight, self.attention_in.bias
        width = tokens.shape[2]
        if first_only:
            query = functional.linear(wanted, weight[:width], bias[:width])
            key, value = functional.linear(tokens, weight[width:], bias[width:]).chunk(2, dim=2)
        else:
            query, key, value = self.attention_in(tokens).chunk(3, dim=2)
        seen = functional.scaled_dot_product_attention(
            self._split(query), self._split(key), self._split(value), attn_mask=mask
        )
        seen = seen.transpose(1, 2).flatten(2)
        wanted = self.norm1(wanted + self.drop(self.attention_out(seen)))
        inner = self.feed_in(wanted)
        inner = functional.gelu(inner) if self.gelu else functional.relu(inner)
        result: Tensor = self.norm2(wanted + self.drop(self.feed_out(inner)))
        return result

    def _split(self, part: Tensor) -> Tensor:
        """(B, T, H) -> (B, heads, T, H / heads)."""
        return part.reshape(*part.shape[:2], self.heads, -1).transpose(1, 2)


class SceneEncoder(nn.Module):
    """Turns the tokens of a scene into its state: a linear map, a learned [CLS] in front, transformer layers.

    Source: ADReFT, section 4.1, "Transformer Encoder". Nothing depends on the order of the tokens.
    """

    def __init__(self, shape: EncoderShape) -> None:
        super().__init__()
        self.shape = shape
        self.embed = nn.Linear(shape.attributes, shape.hidden)
        self.cls = nn.Parameter(torch.empty(shape.hidden))
        self.layers = nn.ModuleList(EncoderLayer(shape) for _ in range(shape.layers))
        nn.init.normal_(self.cls, std=0.02)

    def forward(self, tokens: Tensor, mask: Tensor) -> Tensor:
        """Return the final state of [CLS], (B, H) float32.

        Args:
            tokens: (B, N, c) float32; N may be 0. What stands at places that are not real must be finite.
            mask: (B, N) bool, True where a token is real.
        """
        batch = tokens.shape[0]
        states = torch.cat([self.cls.expand(batch, 1, -1), self.embed(tokens)], dim=1)
        real = functional.pad(mask, (1, 0), value=True)[:, None, None, :]
        last = len(self.layers) - 1
        for place, layer in enumerate(self.layers):
            states = layer(states, real, first_only=place == last)
        return states[:, 0]


class Head(nn.Module):
    """A multi-layer perceptron with a rectifier after every layer but the last: (..., inputs) -> (..., outputs)."""

    def __init__(self, shape: HeadShape) -> None:
        super().__init__()
        self.shape = shape
        widths = shape.widths
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in pairwise(widths))

    def forward(self, inputs: Tensor) -> Tensor:
        """Apply the layers; the outputs are raw (no sigmoid, no softmax)."""
        for layer in self.layers[:-1]:
            inputs = functional.relu(layer(inputs))
        outputs: Tensor = self.layers[-1](inputs)
        return outputs


class SetEncoder(nn.Module):
    """Turns the tokens of a scene into its state as SetShape says."""

    def __init__(self, shape: SetShape) -> None:
        super().__init__()
        self.shape = shape
        self.token = Head(shape.token_shape)

    def forward(self, tokens: Tensor, mask: Tensor) -> Tensor:
        """(B, N, c), (B, N) -> (B, 2 H); N is at least 1, and the first token of every scene is real."""
        values = functional.relu(self.token(tokens))
        # After the rectifier nothing is below 0, so a token that is not real never is the largest.
        largest = (values * mask[:, :, None]).amax(dim=1)
        return torch.cat([largest, values[:, 0]], dim=1)


class Excerpt(nn.Module):
    """Takes out of the tokens of a scene what ExcerptShape names; nothing is learned."""

    def __init__(self, shape: ExcerptShape) -> None:
        super().__init__()
        self.shape = shape
        self._tokens = [token for token, _ in shape.places]
        self._columns = [column for _, column in shape.places]

    def forward(self, tokens: Tensor, mask: Tensor) -> Tensor:  # noqa: ARG002 - as every encoder
        """(B, N, c), (B, N) -> (B, places); the tokens named are there in every scene."""
        return tokens[:, self._tokens, self._columns]


class TextEncoder(nn.Module):
    """BERT over a text whose pieces of words may bear marks; it reads as its twin in numpy (networks.text_encoder)."""

    def __init__(self, shape: TextShape, dropout: float = 0.0) -> None:
        super().__init__()
        self.shape = shape
        self.pieces = nn.Embedding(shape.pieces, shape.hidden)
        self.positions = nn.Embedding(shape.positions, shape.hidden)
        self.marks = nn.Embedding(shape.marks, shape.hidden, padding_idx=0)
        self.norm = nn.LayerNorm(shape.hidden)
        self.drop = nn.Dropout(dropout)
        self.layers = nn.ModuleList(EncoderLayer(shape.layer, dropout) for _ in range(shape.layers))
        nn.init.normal_(self.marks.weight, std=0.02)
        with torch.no_grad():
            self.marks.weight[0] = 0.0  # no mark adds nothing

    def forward(self, pieces: Tensor, marks: Tensor, mask: Tensor) -> Tensor:
        """Return what each piece has come to mean, (B, T, H) float32.

        Args:
            pieces: (B, T) int64, T at most ``shape.positions``.
            marks: (B, T) int64.
            mask: (B, T) bool, True where a piece is real.
        """
        states = self.pieces(pieces) + self.positions.weight[: pieces.shape[1]] + self.marks(marks)
        states = self.drop(self.norm(states))
        for layer in self.layers:
            states = layer(states, mask[:, None, None, :])
        read: Tensor = states
        return read
