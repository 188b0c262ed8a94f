"""What a search technique must offer, and the base of its parameters."""

from collections.abc import Sequence
from typing import Protocol

from pydantic import BaseModel, ConfigDict

from roadmend.search.evaluation import Trial
from roadmend.world.space import Parameters


class TechniqueParameters(BaseModel):
    """Base of all: frozen, strict, and deaf to unknown names."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Technique(Protocol):
    """Asks for points and learns from what they came to.

    Deterministic: the same seed and the same evaluations give the same points. The points of one batch do not depend
    on each other's evaluations, so they may be evaluated side by side.
    """

    def propose(self) -> list[Parameters]:
        """The next batch; never empty. Called in turn with ``learn``."""

    def learn(self, trials: Sequence[Trial]) -> None:
        """Take in the whole batch, in the order proposed."""
