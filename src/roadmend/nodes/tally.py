"""Counts what a repairer did over a run."""

from collections import Counter

from roadmend.core.repair import Interventions, Repair, RepairStatus


class RepairTally:
    """Answers by state, and the interventions among them."""

    def __init__(self) -> None:
        self._states: Counter[RepairStatus] = Counter()
        self._interventions = Interventions()

    def add(self, repair: Repair) -> None:
        """Count one answer."""
        self._states[repair.status] += 1
        self._interventions.add(repair)

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
