"""The guard against forgetting: what is asked of a fine-tuned policy before it takes the old one's place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.measures.driving import DrivingMeasures
from roadmend.networks.checkpoint import Tensors
from roadmend.world.scenario import Scenario


@dataclass(frozen=True, slots=True)
class TuningTrial:
    """The policy after some epochs on the validation set; means of the Driving Score, None where it was not driven."""

    epochs: int  # 0: as it was
    driving_score: float | None  # on the hard scenarios
    ordinary: float | None  # on the ordinary scenarios
    action_loss: float | None = None  # of the last epoch's training
    share: float = 1.0  # of the way from the old weights to those of that epoch


@dataclass(frozen=True)
class TunedCandidate:
    """A trial and the weights that were tried."""

    trial: TuningTrial
    tensors: Tensors


@dataclass
class TuningGuard:
    """Which candidates are worth a look, and which may take the old policy's place.

    All ordinary scenarios count, those that failed before too: where only those count that went well, luck that the old
    policy had is asked of the new one, and even weights that hardly differ lose by that.
    """

    ordinary: Sequence[Scenario]
    hard: Sequence[Scenario]
    tolerance: float  # Driving Score that may be lost on the ordinary scenarios
    _hard_before: float = 0.0
    _ordinary_before: float = 0.0

    def first(self, hard: Sequence[DrivingMeasures], ordinary: Sequence[DrivingMeasures]) -> TuningTrial:
        """What the policy comes to as it is."""
        self._hard_before, self._ordinary_before = _mean(hard), _mean(ordinary)
        return TuningTrial(0, self._hard_before, self._ordinary_before)

    def trial(
        self, epochs: int, hard: Sequence[DrivingMeasures], loss: float | None, share: float = 1.0
    ) -> TuningTrial:
        """What the policy comes to after some epochs, as far as the hard scenarios tell."""
        return TuningTrial(epochs, _mean(hard), None, loss, share)

    def judged(self, candidate: TunedCandidate, ordinary: Sequence[DrivingMeasures]) -> TunedCandidate:
        """A candidate that has driven the ordinary scenarios, too."""
        return replace(candidate, trial=replace(candidate.trial, ordinary=_mean(ordinary)))

    def ranked(self, candidates: Sequence[TunedCandidate]) -> list[TunedCandidate]:
        """Those that are better on the hard scenarios than the policy was, the best first, of equals the earlier."""
        better = [each for each in candidates if _score(each) > self._hard_before]
        return sorted(better, key=_score, reverse=True)

    def allows(self, trial: TuningTrial) -> bool:
        """Whether a trial has lost nothing of what the policy could do; one that has not been judged has."""
        return trial.ordinary is not None and trial.ordinary >= self._ordinary_before - self.tolerance


def _mean(measures: Sequence[DrivingMeasures]) -> float:
    return fmean(each.driving_score for each in measures)


def _score(candidate: TunedCandidate) -> float:
    assert candidate.trial.driving_score is not None
    return candidate.trial.driving_score


def mixture(
    old: Mapping[str, NDArray[Any]], new: Mapping[str, NDArray[Any]], share: float
) -> dict[str, NDArray[np.float32]]:
    """Weights between two models of one ancestry: ``old + share * (new - old)`` (Wortsman et al. 2022, equation 1).

    What fine-tuning breaks it mostly breaks late on that way, and what it mends it mostly mends early.
    """
    return {name: (old[name] + np.float32(share) * (new[name] - old[name])).astype(np.float32) for name in new}
