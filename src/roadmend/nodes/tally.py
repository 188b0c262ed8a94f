"""Counts what a repairer did over a run."""

import math
from collections import Counter

from roadmend.core.repair import Repair, RepairStatus

INTERVAL_S = 0.05  # [s] between ticks


class RepairTally:
    """Interventions by kind, their intensity and dose."""

    def __init__(self) -> None:
        self._states: Counter[RepairStatus] = Counter()
        self._interventions = 0
        self._change = 0.0

    def add(self, repair: Repair) -> None:
        """Count one answer."""
        self._states[repair.status] += 1
        if repair.intervened:
            self._interventions += 1
            change = abs(repair.policy_action - repair.final_action)
            self._change += 0.0 if math.isnan(change) else change  # NaN where the policy said nothing usable

    def values(self) -> dict[str, object]:
        """The counts as plain values."""
        intensity = self._change / self._interventions if self._interventions else 0.0
        return {
            "answers": sum(self._states.values()),
            "interventions": self._interventions,
            "intensity": intensity,
            "dose": self._change * INTERVAL_S,
            **{f"state.{state.name}": count for state, count in sorted(self._states.items())},
        }
