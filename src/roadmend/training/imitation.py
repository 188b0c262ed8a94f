"""Fits the network of a neural policy to the expert's advice."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from roadmend.networks.checkpoint import Checkpoint
from roadmend.networks.encoder import Excerpt, Head, SceneEncoder, SetEncoder
from roadmend.networks.shape import EncoderShape, HeadShape, SetShape
from roadmend.policies.neural_kinds import KINDS, AnyShape, shapes_of
from roadmend.policies.neural_tokens import COLUMNS
from roadmend.training.imitation_configuration import ImitationConfiguration, Round
from roadmend.training.samples import UNASKED, Samples
from roadmend.training.torch_state import load_tensors

_REGRESSION_BETA = 0.1  # of the action: up to this error the regression's loss is a square, from there a line
_SORTED_TOGETHER = 16  # batches whose scenes are sorted by their number of tokens, so that little is padding


class NeuralNetwork(nn.Module):
    """The encoder and the action head under the names of the shipped file."""

    def __init__(self, kind: str, encoder: AnyShape, head: HeadShape) -> None:
        super().__init__()
        self.kind = kind
        self.bins = KINDS[kind].bins
        self.encoder = _encoder(encoder)
        self.head = Head(head)

    def forward(self, tokens: Tensor, mask: Tensor) -> Tensor:
        """(B, N, COLUMNS), (B, N) -> (B, outputs): the action or the logits of its bins, and that of the lane change."""
        outputs: Tensor = self.head(self.encoder(tokens, mask))
        return outputs


def _encoder(shape: AnyShape) -> nn.Module:
    if isinstance(shape, EncoderShape):
        return SceneEncoder(shape)
    return SetEncoder(shape) if isinstance(shape, SetShape) else Excerpt(shape)


def load_network(checkpoint: Checkpoint, path: Path) -> NeuralNetwork:
    """The network of a model.

    Raises:
        InputError: it was trained on other tokens.
    """
    network = NeuralNetwork(str(checkpoint.header["kind"]), *shapes_of(checkpoint, path))
    load_tensors(network, checkpoint.tensors)
    return network


@dataclass(frozen=True, slots=True)
class Losses:
    """Means over some samples."""

    action: float  # cross entropy [nat]; of a regressed action its smooth absolute error
    change: float  # binary cross entropy [nat]
    error: float  # absolute error of the action


@dataclass(frozen=True, slots=True)
class DemonstrationBatch:
    """Some samples, padded."""

    tokens: Tensor  # (B, N, COLUMNS)
    mask: Tensor  # (B, N)
    actions: Tensor  # (B,)
    changes: Tensor  # (B,)


def two_hot(actions: Tensor, bins: int) -> Tensor:
    """Actions in [-1, 1], (B,), as weights on the two nearest of some bins, (B, bins)."""
    places = (actions.clamp(-1.0, 1.0) + 1.0) * (0.5 * (bins - 1))
    low = places.floor().clamp(max=bins - 2).long()
    share = (places - low).unsqueeze(1)
    result = torch.zeros(len(actions), bins, device=actions.device)
    result.scatter_(1, low.unsqueeze(1), 1.0 - share)
    return result.scatter_(1, low.unsqueeze(1) + 1, share)


def batches(
    samples: Samples, rows: NDArray[np.int64], size: int, generator: np.random.Generator | None, device: torch.device
) -> Iterator[DemonstrationBatch]:
    """The rows of the samples in batches; shuffled if a generator is given."""
    begins = np.concatenate([[0], np.cumsum(samples.counts.astype(np.int64))])
    order = rows if generator is None else generator.permutation(rows)
    groups: list[NDArray[np.int64]] = []
    for begin in range(0, len(order), size * _SORTED_TOGETHER):
        chunk = order[begin : begin + size * _SORTED_TOGETHER]
        chunk = chunk[np.argsort(samples.counts[chunk], kind="stable")]
        groups += [chunk[first : first + size] for first in range(0, len(chunk), size)]
    for place in range(len(groups)) if generator is None else generator.permutation(len(groups)):
        chosen = groups[int(place)]
        counts = samples.counts[chosen].astype(np.int64)
        mask = np.arange(counts.max())[None] < counts[:, None]
        tokens = np.zeros((*mask.shape, COLUMNS), dtype=np.float32)
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        tokens[mask] = samples.tokens[np.repeat(begins[chosen], counts) + within]
        yield DemonstrationBatch(
            torch.from_numpy(tokens).to(device),
            torch.from_numpy(mask).to(device),
            torch.from_numpy(samples.actions[chosen]).to(device),
            torch.from_numpy(samples.changes[chosen].astype(np.float32)).to(device),
        )


def losses_of(network: NeuralNetwork, batch: DemonstrationBatch) -> tuple[Tensor, Tensor, Tensor]:
    """Losses of the action and of the lane change (binary cross entropy) and the action's error, each a mean."""
    outputs = network(batch.tokens, batch.mask)
    logits = outputs[:, :-1]
    if network.bins:
        action = functional.cross_entropy(logits, two_hot(batch.actions, network.bins))
        answers = logits.softmax(1) @ torch.linspace(-1.0, 1.0, network.bins, device=logits.device)
    else:
        answers = logits[:, 0]
        action = functional.smooth_l1_loss(answers, batch.actions, beta=_REGRESSION_BETA)
    asked = batch.changes != UNASKED
    change = outputs.new_zeros(())
    if bool(asked.any()):
        # Per batch and not per question, so that a batch with few of them does not count as much as one with many.
        every = functional.binary_cross_entropy_with_logits(outputs[asked, -1], batch.changes[asked], reduction="sum")
        change = every / len(asked)
    error = (answers - batch.actions).abs().mean()
    return action, change, error


def measure(
    network: NeuralNetwork, samples: Samples, rows: NDArray[np.int64], size: int, device: torch.device
) -> Losses:
    """Losses over some rows of the samples."""
    totals = np.zeros(4)
    network.eval()
    with torch.no_grad():
        for batch in batches(samples, rows, size, None, device):
            parts = losses_of(network, batch)
            weight = len(batch.actions)
            totals += [weight * float(parts[0]), weight * float(parts[1]), weight * float(parts[2]), weight]
    return Losses(*(totals[:3] / max(totals[3], 1.0)).tolist())


def split(samples: Samples, held_out: float, families: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows to learn from and rows to measure on; an episode is wholly on one side, in later rounds too.

    Of every family one episode in so many is held out, the families by turns so that few episodes show some of it.

    Args:
        samples: of episodes that go through all families with one seed after another.
        held_out: share of the episodes to measure on.
        families: how many there are.
    """
    period = max(2, round(1.0 / held_out))
    seeds, family = np.divmod(samples.episodes, families)
    kept = (seeds + family * period // families) % period == period - 1
    return np.flatnonzero(~kept), np.flatnonzero(kept)


def learn(
    network: NeuralNetwork,
    optimizer: torch.optim.Optimizer,
    schedule: torch.optim.lr_scheduler.LRScheduler,
    chosen: Iterator[DemonstrationBatch],
    change_weight: float,
) -> Losses:
    """Train on batches, a step each; returns the mean of their losses."""
    network.train()
    sums = np.zeros(4)
    for batch in chosen:
        action, change, error = losses_of(network, batch)
        optimizer.zero_grad(set_to_none=True)
        loss = action + change_weight * change
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        schedule.step()
        sums += [action.item(), change.item(), error.item(), 1.0]
    return Losses(*(sums[:3] / max(sums[3], 1.0)).tolist())


def fit(
    network: NeuralNetwork,
    samples: Samples,
    configuration: ImitationConfiguration,
    step: Round,
    seed: int,
    device: torch.device,
    report: Callable[[int, Losses, Losses | None], None],
) -> Losses | None:
    """Train through the epochs of one round; ``report`` gets each epoch's number and its two losses.

    Returns:
        The losses on the held-out episodes at the end; None where there are too few episodes to hold one out.
    """
    generator = np.random.default_rng(seed)
    rows, held = split(samples, configuration.held_out, len(configuration.families))
    optimizer = torch.optim.AdamW(network.parameters(), lr=step.learning_rate, weight_decay=configuration.weight_decay)
    total = step.epochs * -(-len(rows) // configuration.batch)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, total, 0.02 * step.learning_rate)
    last: Losses | None = None
    for epoch in range(step.epochs):
        chosen = batches(samples, rows, configuration.batch, generator, device)
        learned = learn(network, optimizer, schedule, chosen, configuration.change_weight)
        last = measure(network, samples, held, configuration.batch, device) if len(held) else None
        report(epoch, learned, last)
    return last
