"""Fits a network that answers questions about texts, the vehicles they name and pairs of these."""

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from roadmend.networks.encoder import Head, TextEncoder
from roadmend.networks.shape import HeadShape, TextShape

UNASKED = -1  # an answer that is not known
_SORTED_TOGETHER = 8  # batches whose texts are sorted by their length, so that little is padding
_SMOOTHING = 0.05  # of the answers
_WARM_UP = 0.06  # share of the steps in which the learning rate rises
_LEAST_RATE = 0.02  # share of it that is left at the end
_LARGEST_GRADIENT = 1.0

Weights = Sequence[tuple[int, float]]  # of each question of a group: how many answers, and the weight of its loss


@dataclass(frozen=True, slots=True)
class TextSample:
    """One text and what is known of it; UNASKED where nothing is.

    Attributes:
        pieces: (T,) int64.
        marks: (T,) int64.
        shares: (V, T) float32, how much a piece counts for a vehicle.
        vehicles: (V, questions) int64.
        pairs: (V, V, questions) int64.
        text: (questions,) int64.
    """

    pieces: NDArray[np.int64]
    marks: NDArray[np.int64]
    shares: NDArray[np.float32]
    vehicles: NDArray[np.int64]
    pairs: NDArray[np.int64]
    text: NDArray[np.int64]


Draw = Callable[[random.Random], TextSample]  # a lesson, as it comes this time


@dataclass(frozen=True, slots=True)
class Questions:
    """Of vehicles, of pairs and of the text."""

    vehicles: Weights
    pairs: Weights
    text: Weights


class TextNetwork(nn.Module):
    """A text encoder and three heads, under the names of the shipped file."""

    def __init__(self, shape: TextShape, heads: dict[str, HeadShape], dropout: float = 0.0) -> None:
        super().__init__()
        self.encoder = TextEncoder(shape, dropout)
        self.vehicle, self.pair, self.text = (Head(heads[name]) for name in ("vehicle", "pair", "text"))
        self.drop = nn.Dropout(dropout)

    def forward(self, pieces: Tensor, marks: Tensor, mask: Tensor, shares: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Logits about vehicles (B, V, .), about pairs (B, V, V, .), and about texts (B, .).

        Args:
            pieces: (B, T) int64.
            marks: (B, T) int64.
            mask: (B, T) bool, True where a piece is real.
            shares: (B, V, T) float32.
        """
        states = self.encoder(pieces, marks, mask)
        own = shares / shares.sum(-1, keepdim=True).clamp(min=1e-6) @ states
        begin = states[:, :1]
        mean = (states * mask[..., None]).sum(1) / mask.sum(1, keepdim=True)
        count = own.shape[1]
        first, second = own[:, :, None].expand(-1, -1, count, -1), own[:, None].expand(-1, count, -1, -1)
        pairs = torch.cat([first, second, first * second, begin[:, None].expand_as(first)], -1)
        vehicles = torch.cat([own, begin.expand_as(own)], -1)
        return (
            self.vehicle(self.drop(vehicles)),
            self.pair(self.drop(pairs)),
            self.text(self.drop(torch.cat([mean, begin[:, 0]], -1))),
        )


@dataclass(frozen=True, slots=True)
class _Batch:
    inputs: tuple[Tensor, Tensor, Tensor, Tensor]
    vehicles: Tensor
    pairs: Tensor
    text: Tensor


def fit(
    network: TextNetwork,
    lessons: Sequence[Draw],
    questions: Questions,
    *,
    epochs: int,
    batch: int,
    learning_rate: float,
    seed: int,
    told: Callable[[int, float], None],
) -> None:
    """Teach the lessons, each once an epoch, in an order and a form that are drawn.

    Args:
        network: learns, in place.
        lessons: to be drawn anew in every epoch.
        questions: that they answer.
        epochs: times that each is taught.
        batch: lessons at a time.
        learning_rate: of the encoder; that of its words is a quarter of it, that of the heads five times.
        seed: of all that is drawn.
        told: hears after every step how many there were, and the mean loss of the last [nat].
    """
    generator = random.Random(f"roadmend/text-reading/{seed}")
    torch.manual_seed(seed)
    words = [*network.encoder.pieces.parameters()]
    encoder = [each for name, each in network.encoder.named_parameters() if not name.startswith("pieces.")]
    heads = [each for name, each in network.named_parameters() if not name.startswith("encoder.")]
    rates = (learning_rate, learning_rate / 4, learning_rate * 5)
    groups = [{"params": each, "lr": rate} for each, rate in zip((encoder, words, heads), rates, strict=True)]
    optimizer = torch.optim.AdamW(groups, weight_decay=0.01)
    steps = epochs * -(-len(lessons) // batch)
    rising = max(1, round(_WARM_UP * steps))
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimizer, lambda step: min(1.0, (step + 1) / rising) * max(_LEAST_RATE, 1.0 - step / steps)
    )
    network.train()
    done = 0
    for _ in range(epochs):
        for samples in _batches(lessons, batch, generator):
            loss = _loss(network, _stacked(samples), questions)
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), _LARGEST_GRADIENT)
            optimizer.step()
            schedule.step()
            done += 1
            told(done, float(loss.detach()))
    network.eval()


def _batches(lessons: Sequence[Draw], batch: int, generator: random.Random) -> Iterator[Sequence[TextSample]]:
    order = [*lessons]
    generator.shuffle(order)
    together = batch * _SORTED_TOGETHER
    for start in range(0, len(order), together):
        drawn = sorted((draw(generator) for draw in order[start : start + together]), key=lambda each: len(each.pieces))
        rows = [drawn[at : at + batch] for at in range(0, len(drawn), batch)]
        generator.shuffle(rows)
        yield from rows


def _stacked(samples: Sequence[TextSample]) -> _Batch:
    size, length = len(samples), max(len(each.pieces) for each in samples)
    count = max(len(each.shares) for each in samples)
    pieces, marks = (torch.zeros(size, length, dtype=torch.int64) for _ in range(2))
    mask, shares = torch.zeros(size, length, dtype=torch.bool), torch.zeros(size, count, length)
    vehicles = torch.full((size, count, samples[0].vehicles.shape[-1]), UNASKED)
    pairs = torch.full((size, count, count, samples[0].pairs.shape[-1]), UNASKED)
    for at, each in enumerate(samples):
        own, end = len(each.shares), len(each.pieces)
        pieces[at, :end], marks[at, :end] = torch.from_numpy(each.pieces), torch.from_numpy(each.marks)
        mask[at, :end] = True
        shares[at, :own, :end] = torch.from_numpy(each.shares)
        vehicles[at, :own], pairs[at, :own, :own] = torch.from_numpy(each.vehicles), torch.from_numpy(each.pairs)
    text = torch.stack([torch.from_numpy(each.text) for each in samples])
    return _Batch((pieces, marks, mask, shares), vehicles, pairs, text)


def _loss(network: TextNetwork, batch: _Batch, questions: Questions) -> Tensor:
    """The weighted sum of the cross entropies of all questions [nat]."""
    total = torch.zeros(())
    wanted = (
        (questions.vehicles, batch.vehicles),
        (questions.pairs, batch.pairs),
        (questions.text, batch.text),
    )
    for logits, (weights, answers) in zip(network(*batch.inputs), wanted, strict=True):
        at = 0
        for place, (count, weight) in enumerate(weights):
            own, known = logits[..., at : at + count].reshape(-1, count), answers[..., place].reshape(-1)
            at += count
            if (known != UNASKED).any():
                total = total + weight * functional.cross_entropy(
                    own, known, ignore_index=UNASKED, label_smoothing=_SMOOTHING
                )
    return total
