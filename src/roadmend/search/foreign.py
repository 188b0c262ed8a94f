"""A search technique from outside, as a campaign has it."""

from collections.abc import Sequence
from typing import Any

from roadmend.core.errors import ForeignError
from roadmend.core.foreign import blamed_on
from roadmend.search.evaluation import Trial
from roadmend.search.technique import Technique
from roadmend.world.space import Parameters


class ForeignTechnique:
    """Passes everything on, and says in one line what went wrong."""

    def __init__(self, given: str, technique: Technique) -> None:
        self.technique = technique
        self._where = f"technique {given}"

    def propose(self) -> list[Parameters]:
        """The next batch.

        Raises:
            ForeignError: it fails, or proposes nothing.
        """
        with blamed_on(self._where, "propose"):
            batch: Any = self.technique.propose()
        if not isinstance(batch, list) or not batch or not all(isinstance(point, dict) for point in batch):
            raise ForeignError(self._where, "proposed no points", "answer with a list of them that is never empty")
        return batch

    def learn(self, trials: Sequence[Trial]) -> None:
        """Take in the whole batch.

        Raises:
            ForeignError: it fails.
        """
        with blamed_on(self._where, "learn"):
            self.technique.learn(trials)
