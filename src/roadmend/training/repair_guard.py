"""The guard against forgetting: what is asked of a fine-tuned policy before it takes the old one's place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.evaluation.driving_measures import DrivingMeasures
from roadmend.world.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Trial:
    """The policy after some epochs on the validation set."""

    epochs: int  # 0: as it was
    driving_score: float | None  # mean over the validation set; None where it was not driven
    ordinary: float | None  # mean over its ordinary scenarios that went well before
    action_loss: float | None = None  # of the last epoch's training
    share: float = 1.0  # of the way from the old weights to those of that epoch


@dataclass
class Guard:
    """What is asked of a trial, and what the policy came to before."""

    ordinary: Sequence[Scenario]
    hard: Sequence[Scenario]
    tolerance: float  # Driving Score that may be lost on the ordinary scenarios that went well before
    before: float = 0.0
    _fine: list[int] = field(default_factory=list)  # ordinary scenarios that went well before

    @property
    def scenarios(self) -> list[Scenario]:
        """The validation set, in the order in which the measures are given."""
        return [*self.ordinary, *self.hard]

    def first(self, measures: Sequence[DrivingMeasures]) -> Trial:
        """What the policy comes to as it is."""
        self._fine = [place for place in range(len(self.ordinary)) if measures[place].success]
        trial = self.trial(0, measures, None)
        self.before = trial.ordinary or 0.0
        return trial

    def trial(self, epochs: int, measures: Sequence[DrivingMeasures], loss: float | None, share: float = 1.0) -> Trial:
        """What the policy comes to after some epochs."""
        ordinary = [measures[place].driving_score for place in self._fine]
        whole = fmean(each.driving_score for each in measures)
        return Trial(epochs, whole, fmean(ordinary) if ordinary else 0.0, loss, share)

    def prefers(self, trial: Trial, kept: Trial) -> bool:
        """Whether a trial is better than the one that is kept so far, and has not lost what the policy could do."""
        assert trial.ordinary is not None
        return trial.ordinary >= self.before - self.tolerance and self.is_higher(trial, kept)

    def is_higher(self, trial: Trial, than: Trial) -> bool:
        """Whether a trial has the greater Driving Score, whatever it has lost."""
        assert trial.driving_score is not None
        assert than.driving_score is not None
        return trial.driving_score > than.driving_score


def mixture(
    old: Mapping[str, NDArray[Any]], new: Mapping[str, NDArray[Any]], share: float
) -> dict[str, NDArray[np.float32]]:
    """Weights between two models of one ancestry: ``old + share * (new - old)`` (Wortsman et al. 2022, equation 1).

    What fine-tuning breaks it mostly breaks late on that way, and what it mends it mostly mends early.
    """
    return {
        name: (old[name] + np.float32(share) * (new[name] - old[name])).astype(np.float32) for name in new
    }  # fmt: skip
