"""Counts what a repairer did over a run."""

from collections import Counter
from dataclasses import asdict

from roadmend.core.repair import Interventions, Repair, RepairStatus
from roadmend.core.spell import SpellBuilder


class RepairTally:
    """Answers by state, and the interventions among them."""

    def __init__(self) -> None:
        self._states: Counter[RepairStatus] = Counter()
        self._interventions = Interventions()
        self._spells = SpellBuilder()

    def add(self, time: float, repair: Repair) -> None:
        """Count the answer at ``time`` [s]."""
        self._states[repair.status] += 1
        self._interventions.add(repair)
        self._spells.add(time, repair)

    def values(self) -> dict[str, object]:
        """The counts as plain values."""
        return {
            "answers": sum(self._states.values()),
            "interventions": self._interventions.ticks,
            "change": self._interventions.change,
            "intensity": self._interventions.intensity,
            "dose": self._interventions.dose,
            **{f"state.{state.name}": count for state, count in sorted(self._states.items())},
        }

    def account(self) -> dict[str, object]:
        """The counts and the spells, as plain values."""
        return {**self.values(), "spells": [asdict(spell) for spell in self._spells.spells]}
