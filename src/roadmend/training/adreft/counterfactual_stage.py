"""Practice by counterfactuals: the adapter learns to foresee collisions with and without an intervention.

Like ``practice``, all parameters together; what it learns ``repair.adreft.weighing`` turns into values. Nothing here is
an estimate of an estimate: every label is what an episode came to.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from roadmend.core.errors import InputError
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.counterfactual import Counterfactuals
from roadmend.training.adreft.learning_stage import LearningStage, Loss, cross_entropy
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.trial_set import TrialSet

# Weights of the losses beside the monitor's; decisions that tell of the last two are far fewer.
_DANGER, _AVERTED, _CAUSED = 2.0, 0.5, 0.25


class CounterfactualStage(LearningStage):
    """One run of the stage. It goes on from its state after an interruption."""

    _stream = 7

    def __init__(
        self,
        model: ModelConfiguration,
        section: PracticeSection,
        trials: TrialSet,
        labels: Counterfactuals,
        run: StageRun,
        start: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """As LearningStage, with the labels of the trials.

        Raises:
            InputError: the file is of another run, or the trials tell nothing.
        """
        super().__init__(model, section, trials, run, start)
        if not len(labels.alone) or not len(labels.interfered):
            raise InputError("training split", "has no trial that tells of an intervention", "allow more trials a case")
        self._labels = labels

    def _draw(self, generator: np.random.Generator) -> tuple[NDArray[np.int64], Loss]:
        """Decisions of the policy alone and those that tell of an intervention, and the loss of what is foreseen."""
        labels, section = self._labels, self._section
        drawn = np.concatenate(
            [
                _some(labels.alone, section.decisions_per_epoch, generator),
                _some(labels.interfered, section.tried_per_epoch, generator),
            ]
        )
        return generator.permutation(np.unique(drawn)), self._foresight_loss

    def _foresight_loss(self, outputs: Tensor, chosen: NDArray[np.int64]) -> Tensor:
        """Cross-entropy of what the adapter foresees, logits of shape (B, OUTPUTS)."""
        labels = self._labels
        tried = self._to(labels.tried[chosen])[:, None]
        return (
            _DANGER * self._known(outputs[:, DANGER], labels.danger[chosen])
            + _AVERTED * self._known(outputs[:, AVERTED].gather(1, tried)[:, 0], labels.averted[chosen])
            + _CAUSED * self._known(outputs[:, CAUSED].gather(1, tried)[:, 0], labels.caused[chosen])
        )

    def _known(self, logits: Tensor, labels: NDArray[np.float32]) -> Tensor:
        """Cross-entropy over the decisions of a batch that have this label."""
        known = ~np.isnan(labels)
        return cross_entropy(logits, self._to(np.where(known, labels, 0.0)), self._to(known.astype(np.float32)))


def _some(indices: NDArray[np.int64], number: int, generator: np.random.Generator) -> NDArray[np.int64]:
    """``number`` of the indices in random order, none twice; 0 stands for all."""
    order = generator.permutation(indices)
    return order[:number] if number else order
