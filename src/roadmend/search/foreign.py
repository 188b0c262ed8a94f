"""A search technique from outside, as a campaign has it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from roadmend.core.errors import ForeignError
from roadmend.core.foreign import blamed_on
from roadmend.search.evaluation import Trial
from roadmend.search.technique import Technique
from roadmend.world.space import Parameters, Value


class ForeignTechnique:
    """Passes everything on, and says in one line what went wrong."""

    def __init__(self, given: str, technique: Technique) -> None:
        self.technique = technique
        self._where = f"technique {given}"

    def propose(self) -> list[Parameters]:
        """The next batch.

        Raises:
            ForeignError: it fails, or proposes nothing, or what is no plain value.
        """
        with blamed_on(self._where, "propose"):
            batch: Any = self.technique.propose()
        if not isinstance(batch, list) or not batch or not all(isinstance(point, dict) for point in batch):
            raise ForeignError(self._where, "proposed no points", "answer with a list of them that is never empty")
        return [{name: self._plain(name, value) for name, value in point.items()} for point in batch]

    def learn(self, trials: Sequence[Trial]) -> None:
        """Take in the whole batch.

        Raises:
            ForeignError: it fails.
        """
        with blamed_on(self._where, "learn"):
            self.technique.learn(trials)

    def _plain(self, name: Any, value: Any) -> Value:
        plain = value.item() if isinstance(value, np.generic) else value
        if not isinstance(name, str) or not isinstance(plain, float | int | str):
            what = f"proposed {name!r} as {type(value).__name__}"
            raise ForeignError(self._where, what, "answer with numbers and texts, by the names of the space")
        return plain
