"""Practice: monitor and adapter learn from trials what every action is worth, all parameters together.

Fitted Q iteration (Ernst et al. 2005) on the trials: first on what the episodes came to, then on the value of the
best action some decisions later. It stands in the place of the paper's cross-entropy on weak labels (ADReFT section
3.2.1), which says "brake fully" wherever a collision is near; ReFT goes on from here as from there.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.learning_stage import LearningStage, Loss
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.trial_set import TrialSet

_JUDGED = 1024  # decisions of a batch that is only judged


class PracticeStage(LearningStage):
    """One run of the stage. It goes on from its state after an interruption."""

    def __init__(
        self,
        model: ModelConfiguration,
        section: PracticeSection,
        trials: TrialSet,
        run: StageRun,
        start: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """As LearningStage.

        Raises:
            InputError: the file is of another run, or there is no trial.
        """
        super().__init__(model, section, trials, run, start)
        self._trials = trials

    def _draw(self, generator: np.random.Generator) -> tuple[NDArray[np.int64], Loss]:
        """Indices of an epoch's decisions, and the loss of what the adapter says of them."""
        drawn = self._trials.draw(self._section.decisions_per_epoch, generator)
        return drawn, partial(self._loss, self._targets(drawn))

    def _targets(self, drawn: NDArray[np.int64]) -> Tensor:
        """What every chosen action should be worth, shape (F,); zero where it was not drawn."""
        trials = self._trials
        if self.epoch < self._section.monte_carlo_epochs:
            return torch.from_numpy(trials.total)
        following = trials.following[drawn]
        best = np.zeros(len(trials), dtype=np.float32)
        self.network.eval()
        with torch.no_grad():
            for chosen in trials.sorted_batches_of(np.unique(following[following >= 0]), _JUDGED):
                batch = trials.batch(chosen)
                _, values = self.network(self._to(batch.tokens), self._to(batch.mask), self._to(batch.action))
                best[chosen] = values.max(dim=1).values.cpu().numpy()
        ahead = np.where(following >= 0, best[following], 0.0)
        targets = np.zeros(len(trials), dtype=np.float32)
        # Every reward is a price, so no value is above zero: an estimate that is would feed upon itself.
        targets[drawn] = trials.reward[drawn] + trials.discount[drawn] * np.minimum(ahead, 0.0)
        return torch.from_numpy(targets)

    def _loss(self, targets: Tensor, outputs: Tensor, chosen: NDArray[np.int64]) -> Tensor:
        """How far the adapter's outputs, shape (B, actions), are from what the chosen decisions should be worth."""
        counted = torch.from_numpy(self._trials.alike)[chosen].to(self._run.device, torch.float32)
        wanted = targets[chosen].to(self._run.device)[:, None].expand_as(outputs)
        apart = functional.smooth_l1_loss(outputs, wanted, reduction="none") * counted
        return (apart.sum(dim=1) / counted.sum(dim=1).clamp(min=1.0)).mean()
