"""What a change monitor learns of lane changes, and the threshold from which it holds them back."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from roadmend.networks.encoder import Head, SceneEncoder
from roadmend.repair.adreft.change_monitor import PREFIX, ChangeConfiguration, ChangeMonitor
from roadmend.training.adreft.change_drives import CaseChanges
from roadmend.training.adreft.change_settings import ChangeSettings
from roadmend.training.adreft.network import load_tensors, tensors_of
from roadmend.training.adreft.stage import Tensors
from roadmend.training.adreft.token_rows import TokenRows


class _ChangeNetwork(nn.Module):
    """An encoder of its own and a head, as ``repair.adreft.change_monitor`` has them."""

    def __init__(self, configuration: ChangeConfiguration, dropout: float) -> None:
        super().__init__()
        self.encoder = SceneEncoder(configuration.encoder)
        self.head = Head(configuration.head_shape)
        self._dropout = nn.Dropout(dropout)

    def forward(self, tokens: Tensor, mask: Tensor) -> Tensor:
        """Logits, shape (B,), of tokens of shape (B, N, c) and their mask of shape (B, N)."""
        logit: Tensor = self.head(self._dropout(self.encoder(tokens, mask)))[:, 0]
        return logit


def learn_changes(
    configuration: ChangeConfiguration,
    settings: ChangeSettings,
    changes: Sequence[CaseChanges],
    start: Mapping[str, NDArray[Any]],
    seed: int,
    report: Callable[[int, float], None] = lambda _epoch, _loss: None,
) -> Tensors:
    """The tensors of a change monitor, by the names that a model's file has.

    Args:
        configuration: of the monitor.
        settings: how it learns.
        changes: of cases, at least one change in all.
        start: tensors with the encoder of the state monitor, with which its own begins.
        seed: of weights and order.
        report: called after every epoch with its number, from 1, and its mean loss.
    """
    rows, collided = _joined(changes), np.concatenate([entry.collided for entry in changes])
    torch.manual_seed(seed)
    network = _ChangeNetwork(configuration, settings.dropout)
    load_tensors(network.encoder, start, "encoder.")
    optimizer = torch.optim.AdamW(network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay)
    network.train()
    for epoch in range(settings.epochs):
        generator = np.random.default_rng([seed, epoch])
        for group in optimizer.param_groups:
            group["lr"] = 0.5 * settings.learning_rate * (1.0 + math.cos(math.pi * epoch / settings.epochs))
        total = 0.0
        for batch in rows.batches_of(generator.permutation(len(rows)), settings.batch, generator):
            tokens, mask = rows.padded(batch)
            tokens += settings.noise * generator.standard_normal(tokens.shape, dtype=np.float32) * (tokens != 0.0)
            logits = network(torch.from_numpy(tokens), torch.from_numpy(mask))
            loss = functional.binary_cross_entropy_with_logits(logits, torch.from_numpy(collided[batch]))
            optimizer.zero_grad(set_to_none=True)
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimizer.step()
            total += loss.item() * len(batch)
        report(epoch + 1, total / len(rows))
    return tensors_of(network, PREFIX)


def risks_of(monitor: ChangeMonitor, changes: Sequence[CaseChanges]) -> NDArray[np.float64]:
    """The risk that a monitor sees in each change, 0 .. 1."""
    rows = _joined(changes)
    ends = zip(rows.offsets[:-1], rows.offsets[1:], strict=True)
    return np.array([monitor.risk(rows.tokens[begin:end].astype(np.float32)) for begin, end in ends])


def threshold_of(risks: NDArray[np.float64], collided: NDArray[np.float32], held: float) -> float:
    """The risk that a share ``held`` of the harmless changes is above."""
    return float(np.quantile(risks[collided < 0.5], 1.0 - held))


def _joined(changes: Sequence[CaseChanges]) -> TokenRows:
    counts = np.concatenate([entry.counts for entry in changes]).astype(np.int64)
    return TokenRows(np.concatenate([entry.tokens for entry in changes]), np.concatenate([[0], np.cumsum(counts)]))
