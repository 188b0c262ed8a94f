"""What a search technique must offer, and the base of its parameters."""

from collections.abc import Sequence
from typing import Protocol

from roadmend.core import parameters
from roadmend.search.evaluation import Trial
from roadmend.world.space import Parameters


class TechniqueParameters(parameters.Parameters):
    """Base of what can be set."""


class Technique(Protocol):
    """Asks for points and learns from what they came to.

    Deterministic: the same seed and the same evaluations give the same points. The points of one batch do not depend
    on each other's evaluations, so they may be evaluated side by side.
    """

    def propose(self) -> list[Parameters]:
        """The next batch; never empty. Called in turn with ``learn``."""

    def learn(self, trials: Sequence[Trial]) -> None:
        """Take in the whole batch, in the order proposed."""
