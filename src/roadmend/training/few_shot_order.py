"""One of the orders in which few-shot repair shows its scenes, and the mean of the weights that several lead to."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import numpy as np
import torch
from numpy.typing import NDArray

from roadmend.learning.checkpoint import Tensors
from roadmend.policies.neural import load_model
from roadmend.training.few_shot_settings import FewShotSettings
from roadmend.training.imitation import batches, learn, load_network, tensors_of
from roadmend.training.samples import Samples


@dataclass(frozen=True)
class Order:
    """A fine-tuning of a policy on scenes in one order."""

    model: Path  # the policy's model file
    settings: FewShotSettings
    shown: Samples  # demonstrated
    old: Samples | None  # of ordinary episodes; None: no replay
    seed: int
    number: int  # of the order


@dataclass(frozen=True)
class Epoch:
    """What an epoch led to."""

    tensors: Tensors
    loss: float  # of the action


def tune(order: Order) -> list[Epoch]:
    """The weights after every epoch; the same order gives the same bits.

    Raises:
        InputError: the model is no neural policy's.
    """
    settings, shown, old = order.settings, order.shown, order.old
    parent = load_model(order.model)
    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # sums in another number of threads are others
    try:
        torch.manual_seed(order.seed)
        generator = np.random.default_rng([order.seed, order.number])
        network = load_network(parent, order.model)
        samples = shown if old is None else Samples.join([shown, old])
        share = settings.replay_share if old is not None else 0.0
        replayed = round(len(shown) * share / (1.0 - share))
        optimizer = torch.optim.AdamW(
            network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
        )
        steps = settings.epochs * -(-(len(shown) + replayed) // settings.batch)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps, 0.02 * settings.learning_rate)
        change_weight = float(parent.header["configuration"]["training"]["change_weight"])
        epochs = []
        for _ in range(settings.epochs):
            rows = _rows(len(shown), len(samples), replayed, generator)
            chosen = batches(samples, rows, settings.batch, generator, torch.device("cpu"))
            loss = learn(network, optimizer, schedule, chosen, change_weight).action
            epochs.append(Epoch({name: array.copy() for name, array in tensors_of(network).items()}, loss))
    finally:
        torch.set_num_threads(threads)
    return epochs


def mean_of(orders: Sequence[Sequence[Epoch]]) -> Iterator[Epoch]:
    """After every epoch the mean of the weights of all orders, and that of their losses.

    Fine-tunings that begin at one model mostly end in one basin; the mean of their weights does as well as the mean of
    their answers, and depends less on the order of the scenes than any one (Wortsman et al. 2022, "Model soups").
    """
    for epochs in zip(*orders, strict=True):
        tensors = {
            name: np.stack([each.tensors[name] for each in epochs]).mean(axis=0, dtype=np.float64).astype(np.float32)
            for name in epochs[0].tensors
        }
        yield Epoch(tensors, fmean(each.loss for each in epochs))


def _rows(shown: int, total: int, replayed: int, generator: np.random.Generator) -> NDArray[np.int64]:
    """All that was demonstrated, and as much of the old as is wanted: each once before any twice."""
    count = total - shown
    if not count or not replayed:
        return np.arange(shown)
    turns = [generator.permutation(count) for _ in range(-(-replayed // count))]
    return np.concatenate([np.arange(shown), shown + np.concatenate(turns)[:replayed]])
