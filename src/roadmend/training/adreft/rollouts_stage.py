"""Reinforcement fine-tuning on rollouts: the adapter learns what acting gains over waiting, all else frozen.

What an adapter foresees is weighed into values (``repair.adreft.weighing``); the difference of two of them is fitted to
what was gained. Time that is lost is no collision, but it is paid in the same coin: an action that loses much looks
like one that causes collisions, which is what keeps the adapter from choosing it.
"""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from roadmend.core.errors import InputError
from roadmend.networks.encoder import Head
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER
from roadmend.training.adreft.case_rollouts import CaseRollouts
from roadmend.training.adreft.network import AdreftNetwork
from roadmend.training.adreft.rollouts_configuration import RolloutsSection
from roadmend.training.adreft.token_rows import TokenRows
from roadmend.training.torch_state import load_tensors, tensors_of

_ADAPTER = "adapter."
_BLOCK = 256  # moments that are encoded in one go
_FOLDS = 10_000


@dataclass(frozen=True, slots=True)
class TuningFigures:
    """What the fit came to; losses are mean Huber losses of gains, in the units of the prices."""

    moments: int
    tried: int
    epoch: int  # that is kept; 0: the adapter as it was
    loss_before: float  # on held-out cases
    loss: float  # on them, of the adapter that is kept
    gained: float  # mean gain on held-out moments of the choice that the kept adapter likes best among the tried, or 0
    gained_before: float  # the same of the adapter as it was


class RolloutsStage:
    """One fit of the adapter."""

    def __init__(
        self,
        model: ModelConfiguration,
        section: RolloutsSection,
        rollouts: Sequence[CaseRollouts],
        tensors: Mapping[str, NDArray[Any]],
        seed: int,
        device: str,
    ) -> None:
        """Encode all moments.

        Args:
            model: what the networks are; ``weighing`` holds the prices.
            section: how.
            rollouts: of all cases so far.
            tensors: of the networks that drove.
            seed: of the order of the moments, and of what is left out.
            device: torch's name of where to compute.

        Raises:
            InputError: at no moment was anything tried, or no case is held out, or every one.
        """
        assert model.weighing is not None
        looked = [entry for entry in rollouts if len(entry.moment)]
        if not looked:
            raise InputError("rollouts", "show no moment at which to act", "lower rollouts.score or give more cases")
        self._section, self._collision, self._seed, self._device = section, model.weighing.collision, seed, device
        self._tensors = dict(tensors)
        self._adapter = Head(model.adapter_shape).to(device)
        load_tensors(self._adapter, self._tensors, _ADAPTER)
        self._states = self._encode(model, looked)
        begins = np.cumsum([0, *map(len, looked)])[:-1]
        self._moment = np.concatenate([entry.moment + begin for entry, begin in zip(looked, begins, strict=True)])
        self._choice = np.concatenate([entry.choice for entry in looked]).astype(np.int64)
        self._collided = np.concatenate([entry.collided for entry in looked])
        then = np.concatenate([entry.collided_then for entry in looked])
        lost = np.concatenate([entry.lost for entry in looked])
        averted = self._collision * (self._collided[self._moment] - then)
        self._gain = (averted - section.time * lost).astype(np.float32)
        held = [zlib.crc32(entry.name.encode()) % _FOLDS < section.held_out * _FOLDS for entry in looked]
        if all(held) or not any(held):  # no epoch can be judged, or none learns: the adapter would stay as it was
            what = f"of {len(held)} cases with a moment {'all are' if held[0] else 'none is'} held out"
            raise InputError("rollouts", what, "give more cases, or set rollouts.held_out")
        self._held = np.repeat(held, [len(entry) for entry in looked])  # of each moment

    def run(self) -> tuple[dict[str, NDArray[Any]], TuningFigures]:
        """The tensors of the whole network with the adapter of the best epoch, and what it came to."""
        section = self._section
        optimizer = torch.optim.AdamW(
            self._adapter.parameters(), lr=section.learning_rate, weight_decay=section.weight_decay
        )
        torch.manual_seed(self._seed)
        generator = np.random.default_rng([self._seed, 13])
        learned, held = (np.flatnonzero(self._held[self._moment] == kind) for kind in (False, True))
        before, gained_before = self._judge(held)
        best, kept, gained = before, tensors_of(self._adapter, _ADAPTER), gained_before
        epoch = 0
        for number in range(1, section.epochs + 1):
            self._adapter.train()
            order = generator.permutation(learned)
            for start in range(0, len(order), section.batch):
                loss = self._loss(order[start : start + section.batch], generator)
                optimizer.zero_grad(set_to_none=True)
                loss.backward()  # type: ignore[no-untyped-call]
                optimizer.step()
            loss_held, gained_held = self._judge(held)
            if loss_held < best:
                best, kept, gained, epoch = loss_held, tensors_of(self._adapter, _ADAPTER), gained_held, number
        figures = TuningFigures(
            len(self._states), len(self._choice), epoch, before, best, gained=gained, gained_before=gained_before
        )
        return {**self._tensors, **kept}, figures

    def _encode(self, model: ModelConfiguration, looked: Sequence[CaseRollouts]) -> Tensor:
        """States of all moments, shape (F, H)."""
        network = AdreftNetwork(model).to(self._device)
        load_tensors(network, self._tensors)
        network.eval()
        counts = np.concatenate([entry.counts for entry in looked]).astype(np.int64)
        rows = TokenRows(np.concatenate([entry.tokens for entry in looked]), np.concatenate([[0], counts.cumsum()]))
        states = []
        with torch.no_grad():
            for start in range(0, len(rows), _BLOCK):
                padded = rows.padded(np.arange(start, min(start + _BLOCK, len(rows))))
                states.append(network.encoder(*map(self._to, padded)))
        return torch.cat(states)

    def _gains(self, tried: NDArray[np.int64], states: Tensor) -> tuple[Tensor, Tensor]:
        """What acting gains over waiting, before prices of strength, as the adapter foresees it; and its danger."""
        outputs = torch.sigmoid(self._adapter(states))
        danger = outputs[:, DANGER]
        choice = self._to(self._choice[tried])[:, None]
        averted, caused = (outputs[:, part].gather(1, choice)[:, 0] for part in (AVERTED, CAUSED))
        return self._collision * (danger * averted - (1.0 - danger) * caused), danger

    def _loss(self, tried: NDArray[np.int64], generator: np.random.Generator) -> Tensor:
        states, moments = self._states[self._moment[tried]], self._moment[tried]
        if self._section.dropout:
            kept = generator.random(tuple(states.shape)) >= self._section.dropout
            states = states * self._to(kept.astype(np.float32) / (1.0 - self._section.dropout))
        gains, danger = self._gains(tried, states)
        fit = functional.huber_loss(gains, self._to(self._gain[tried]))
        waiting = functional.binary_cross_entropy(danger, self._to(self._collided[moments]))
        return fit + waiting

    def _judge(self, tried: NDArray[np.int64]) -> tuple[float, float]:
        """Loss of the gains, and what the adapter's favourites among the tried come to; NaN-free, 0 of none."""
        if not len(tried):
            return 0.0, 0.0
        self._adapter.eval()
        with torch.no_grad():
            gains, _ = self._gains(tried, self._states[self._moment[tried]])
            loss = functional.huber_loss(gains, self._to(self._gain[tried])).item()
        said, seen = gains.cpu().numpy(), self._gain[tried]
        moments, place = np.unique(self._moment[tried], return_inverse=True)
        order = np.lexsort((-said, place))
        first = order[np.searchsorted(place[order], np.arange(len(moments)))]
        return loss, float(np.where(said[first] > 0.0, seen[first], 0.0).mean())

    def _to(self, array: NDArray[Any]) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(array)).to(self._device)
