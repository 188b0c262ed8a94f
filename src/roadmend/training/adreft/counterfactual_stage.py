"""Practice by counterfactuals: the adapter learns to foresee collisions with and without an intervention.

Like ``practice``, all parameters together; what it learns ``repair.adreft.weighing`` turns into values. Nothing here is
an estimate of an estimate: every label is what an episode came to.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from roadmend.core.errors import InputError, RoadmendError
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.counterfactual import Counterfactuals
from roadmend.training.adreft.forgetting import forget
from roadmend.training.adreft.practice import PracticeFigures, PracticeStage
from roadmend.training.adreft.trial_set import TrialSet

# Weights of the losses beside the monitor's; decisions that tell of the last two are far fewer.
_DANGER, _AVERTED, _CAUSED = 2.0, 0.5, 0.25
_CLIP = 1.0  # largest norm of the gradient


class CounterfactualStage(PracticeStage):
    """One run of the stage. ``state`` is the file from which it goes on after an interruption."""

    def __init__(
        self, model: ModelConfiguration, section: PracticeSection, trials: TrialSet, labels: Counterfactuals,
        *, seed: int, device: str, state: Path, log: Path | None = None, start: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:  # fmt: skip
        """As PracticeStage, with the labels of the trials.

        Raises:
            InputError: the file is of another run, or the trials tell nothing.
        """
        super().__init__(model, section, trials, seed=seed, device=device, state=state, log=log, start=start)
        if not len(labels.alone) or not len(labels.interfered):
            raise InputError("training split", "has no trial that tells of an intervention", "allow more trials a case")
        self._labels = labels

    def _learn(self) -> PracticeFigures:
        """One epoch; its chance comes from the seed and its number alone."""
        trials, labels, section = self._trials, self._labels, self._section
        generator = np.random.default_rng([self._seed, 7, self.epoch])
        drawn = np.concatenate([
            _some(labels.alone, section.decisions_per_epoch, generator),
            _some(labels.interfered, section.tried_per_epoch, generator),
        ])  # fmt: skip
        drawn = generator.permutation(np.unique(drawn))
        critical, judged = torch.from_numpy(trials.critical), torch.from_numpy(trials.judged)
        steps = math.ceil(len(drawn) / section.batch)
        value_total, monitor_total, count = 0.0, 0.0, 0
        self.network.train()
        for chosen in trials.batches(drawn, section.batch, generator):
            for group in self._optimizer.param_groups:
                group["lr"] = self._rate(self.epoch + count / steps)
            batch = trials.batch(chosen)
            mask = batch.mask if not section.forget else forget(batch.tokens, batch.mask, section.forget, generator)
            logits, foreseen = self._judge(batch, mask, generator)
            says = judged[chosen].to(self._device)
            monitor = _cross_entropy(logits, critical[chosen].to(self._device), says)
            tried = self._to(labels.tried[chosen])[:, None]
            value = (
                _DANGER * self._known(foreseen[:, DANGER], labels.danger[chosen])
                + _AVERTED * self._known(foreseen[:, AVERTED].gather(1, tried)[:, 0], labels.averted[chosen])
                + _CAUSED * self._known(foreseen[:, CAUSED].gather(1, tried)[:, 0], labels.caused[chosen])
            )
            self._optimizer.zero_grad(set_to_none=True)
            (value + monitor).backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(self.network.parameters(), _CLIP)
            self._optimizer.step()
            value_total, monitor_total = value_total + value.item(), monitor_total + monitor.item()
            count += 1
        if not math.isfinite(value_total + monitor_total):
            raise RoadmendError("the loss is no longer finite; try a lower learning rate")
        return PracticeFigures(self.epoch + 1, value_total / count, monitor_total / count)

    def _known(self, logits: Tensor, labels: NDArray[np.float32]) -> Tensor:
        """Cross-entropy over the decisions of a batch that have this label."""
        known = ~np.isnan(labels)
        return _cross_entropy(logits, self._to(np.where(known, labels, 0.0)), self._to(known.astype(np.float32)))


def _cross_entropy(logits: Tensor, labels: Tensor, weight: Tensor) -> Tensor:
    wrong = functional.binary_cross_entropy_with_logits(logits, labels, weight=weight, reduction="sum")
    return wrong / weight.sum().clamp(min=1.0)


def _some(indices: NDArray[np.int64], number: int, generator: np.random.Generator) -> NDArray[np.int64]:
    """``number`` of the indices in random order, none twice; 0 stands for all."""
    order = generator.permutation(indices)
    return order[:number] if number else order
