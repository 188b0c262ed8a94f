"""What a risk monitor learns of ticks and what came of them, and how its threshold is set."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from roadmend.core.errors import InputError
from roadmend.networks.encoder import Head, SceneEncoder
from roadmend.repair.adreft.risk_monitor import RiskConfiguration, RiskMonitor
from roadmend.training.adreft.case_risks import CaseRisks
from roadmend.training.adreft.risk_settings import RiskSettings
from roadmend.training.adreft.stage import Tensors
from roadmend.training.adreft.token_rows import TokenRows
from roadmend.training.device import one_thread
from roadmend.training.torch_state import load_tensors, tensors_of

_EMBED = "encoder.embed.weight"  # of the state monitor's encoder, shape (H, c)


class _RiskNetwork(nn.Module):
    """An encoder of its own and a head, as ``repair.adreft.risk_monitor`` has them."""

    def __init__(self, configuration: RiskConfiguration, dropout: float) -> None:
        super().__init__()
        self.encoder = SceneEncoder(configuration.encoder)
        self.head = Head(configuration.head_shape)
        self._dropout = nn.Dropout(dropout)

    def forward(self, tokens: Tensor, mask: Tensor) -> Tensor:
        """Logits, shape (B,), of tokens of shape (B, N, c) and their mask of shape (B, N)."""
        logit: Tensor = self.head(self._dropout(self.encoder(tokens, mask)))[:, 0]
        return logit


@one_thread()
def learn_risks(
    configuration: RiskConfiguration,
    settings: RiskSettings,
    cases: Sequence[CaseRisks],
    start: Mapping[str, NDArray[Any]],
    prefix: str,
    seed: int,
    report: Callable[[int, float], None] = lambda _epoch, _loss: None,
) -> Tensors:
    """The tensors of a risk monitor, by the names that a model's file has; computed on one thread of the CPU.

    Args:
        configuration: of the monitor.
        settings: how it learns.
        cases: what to learn of, at least one tick in all.
        start: tensors with the encoder of the state monitor, with which its own begins.
        prefix: of the names, "need." or "change.".
        seed: of weights and order.
        report: called after every epoch with its number, from 1, and its mean loss.
    """
    rows, collided = _joined(cases), np.concatenate([entry.collided for entry in cases])
    torch.manual_seed(seed)
    network = _RiskNetwork(configuration, settings.dropout)
    load_tensors(network.encoder, _widened(start, configuration.encoder.attributes), "encoder.")
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
    return tensors_of(network, prefix)


def _widened(start: Mapping[str, NDArray[Any]], attributes: int) -> dict[str, NDArray[Any]]:
    """The tensors of an encoder that takes more attributes, and makes nothing of the further ones yet."""
    embed = start[_EMBED]
    further = np.zeros((len(embed), attributes - embed.shape[1]), dtype=embed.dtype)
    return {**start, _EMBED: np.concatenate([embed, further], axis=1)}


def risks_of(monitor: RiskMonitor, cases: Sequence[CaseRisks]) -> NDArray[np.float64]:
    """The risk that a monitor sees in each tick of all cases, 0 .. 1."""
    rows = _joined(cases)
    ends = zip(rows.offsets[:-1], rows.offsets[1:], strict=True)
    return np.array([monitor.risk(rows.tokens[begin:end].astype(np.float32)) for begin, end in ends])


def threshold_by_ticks(risks: NDArray[np.float64], cases: Sequence[CaseRisks], share: float) -> float:
    """The risk that a share of the harmless ticks is above."""
    collided = np.concatenate([entry.collided for entry in cases])
    return float(np.quantile(risks[collided < 0.5], 1.0 - share))


def threshold_by_drives(risks: NDArray[np.float64], cases: Sequence[CaseRisks], share: float) -> float:
    """The risk that is exceeded in a share of the harmless drives, of cases of one drive each.

    Raises:
        InputError: no drive is harmless.
    """
    ends = np.cumsum([len(entry) for entry in cases])
    drives = np.split(risks, ends[:-1])
    worst = [drive.max(initial=0.0) for drive, entry in zip(drives, cases, strict=True) if not entry.collided.any()]
    if not worst:
        raise InputError("validation drives", "all end badly", "set more validation_cases, or other families")
    return float(np.quantile(worst, 1.0 - share))


def _joined(cases: Sequence[CaseRisks]) -> TokenRows:
    counts = np.concatenate([entry.counts for entry in cases]).astype(np.int64)
    return TokenRows(np.concatenate([entry.tokens for entry in cases]), np.concatenate([[0], np.cumsum(counts)]))
