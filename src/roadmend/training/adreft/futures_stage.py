"""Practice on futures: the monitor learns how likely a violation is, the adapter what a pulse of braking changes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from roadmend.core.errors import InputError
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.learning_stage import LearningStage, Loss
from roadmend.training.adreft.moment_set import MomentSet
from roadmend.training.adreft.stage import StageRun

_DANGER, _AVERTED, _CAUSED = 1.0, 0.5, 0.25  # weights of the losses beside the monitor's


class FuturesStage(LearningStage):
    """One run of the stage. It goes on from its state after an interruption."""

    _stream = 11

    def __init__(
        self,
        model: ModelConfiguration,
        section: PracticeSection,
        moments: MomentSet,
        run: StageRun,
        start: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """As LearningStage.

        Raises:
            InputError: the file is of another run, or nothing was tried at any moment.
        """
        super().__init__(model, section, moments, run, start)
        if not moments.averted_of.any() and not moments.caused_of.any():
            raise InputError("training split", "has no moment at which something was tried", "give more cases")
        self._moments = moments

    def _draw(self, generator: np.random.Generator) -> tuple[NDArray[np.int64], Loss]:
        """Moments in random order, and the loss of what is foreseen of them."""
        return self._moments.draw(self._section.decisions_per_epoch, generator), self._foresight_loss

    def _monitor_loss(self, logits: Tensor, chosen: NDArray[np.int64]) -> Tensor:
        """Cross-entropy with the share of futures that violate.

        Divided by the number of moments, not by their weight: a batch of those that weigh little must not count as
        much as any other, or the chances come out too high.
        """
        moments = self._moments
        labels, weight = self._to(moments.critical[chosen]), self._to(moments.judged[chosen])
        return functional.binary_cross_entropy_with_logits(logits, labels, weight=weight)

    def _foresight_loss(self, outputs: Tensor, chosen: NDArray[np.int64]) -> Tensor:
        """Cross-entropy of what the adapter foresees, logits of shape (B, OUTPUTS)."""
        moments = self._moments
        return (
            _DANGER * self._monitor_loss(outputs[:, DANGER], chosen)
            + _AVERTED * self._tried_loss(outputs[:, AVERTED], moments.averted[chosen], moments.averted_of[chosen])
            + _CAUSED * self._tried_loss(outputs[:, CAUSED], moments.caused[chosen], moments.caused_of[chosen])
        )

    def _tried_loss(self, logits: Tensor, shares: NDArray[np.float32], behind: NDArray[np.float32]) -> Tensor:
        """The same of what was tried, all of shape (B, actions), by the number of futures behind each share."""
        wrong = functional.binary_cross_entropy_with_logits(
            logits, self._to(shares), weight=self._to(behind), reduction="sum"
        )
        return wrong / max(1.0, float(behind.sum()))
