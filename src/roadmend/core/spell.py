"""An intervention from its first tick to its last."""

from dataclasses import dataclass

from roadmend.core.repair import Interventions, Repair
from roadmend.core.tick import INTERVAL


@dataclass(frozen=True, slots=True)
class Spell:
    """Uninterrupted ticks at which the command was replaced."""

    begin: float  # [s]
    ticks: int
    change: float  # sum of |policy's action - final action| over them, 0 .. 2 each
    need: float | None = None  # share of futures from its first tick, unrepaired, that violate; None: not looked at
    held_back: int = 0  # lane changes that the policy asked for in it and the merger held back

    @property
    def dose(self) -> float:
        """Seconds of full command by which it changed the drive."""
        return Interventions(self.ticks, self.change).dose

    @property
    def end(self) -> float:
        """When the policy's command counts again [s]."""
        return self.begin + self.ticks * INTERVAL


class SpellBuilder:
    """Takes in answer by answer and tells the spells."""

    def __init__(self) -> None:
        self._spells: list[Spell] = []
        self._is_open = False

    def add(self, time: float, repair: Repair) -> bool:
        """Take in the answer at ``time`` [s]; returns whether a spell begins with it."""
        begins = repair.intervened and not self._is_open
        if begins:
            self._spells.append(Spell(time, 1, repair.change, held_back=int(repair.held_back)))
        elif repair.intervened:
            last = self._spells[-1]
            held_back = last.held_back + repair.held_back
            self._spells[-1] = Spell(last.begin, last.ticks + 1, last.change + repair.change, held_back=held_back)
        self._is_open = repair.intervened
        return begins

    @property
    def spells(self) -> tuple[Spell, ...]:
        """Those so far, the last perhaps unfinished."""
        return tuple(self._spells)
