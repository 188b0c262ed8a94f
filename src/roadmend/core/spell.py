"""An intervention from its first tick to its last."""

import math
from dataclasses import dataclass, replace

from roadmend.core.repair import Interventions, Repair
from roadmend.core.tick import INTERVAL

_SAME = 1e-6  # [s] by which times of the same rate may differ


@dataclass(frozen=True, slots=True)
class Spell:
    """Uninterrupted ticks at which the command was replaced."""

    begin: float  # [s]
    ticks: int
    change: float  # sum of |policy's action - final action| over them, 0 .. 2 each, weighed with their part of INTERVAL
    need: float | None = None  # share of futures from its first tick, unrepaired, that violate; None: not looked at
    held_back: int = 0  # lane changes that the policy asked for in it and the merger held back
    extra_time: float = 0.0  # [s] that they lasted beyond INTERVAL each; not 0 where the commands' rate is another

    @property
    def dose(self) -> float:
        """Seconds of full command by which it changed the drive."""
        return Interventions(self.ticks, self.change).dose

    @property
    def end(self) -> float:
        """When the policy's command counts again [s]."""
        return self.begin + self.ticks * INTERVAL + self.extra_time


class SpellBuilder:
    """Takes in answer by answer and tells the spells.

    An answer lasts until the next one; INTERVAL where none follows, or where the clock was set back.
    """

    def __init__(self) -> None:
        self._spells: list[Spell] = []
        self._is_open = False
        self._last = (0.0, 0.0)  # time [s] and change of the last answer

    def add(self, time: float, repair: Repair) -> bool:
        """Take in the answer at ``time`` [s]; returns whether a spell begins with it."""
        begins = repair.intervened and not self._is_open
        if self._is_open:
            self._weigh_last(time)
        if begins:
            self._spells.append(Spell(time, 1, repair.change, held_back=int(repair.held_back)))
        elif repair.intervened:
            last = self._spells[-1]
            held_back = last.held_back + repair.held_back
            change = last.change + repair.change
            self._spells[-1] = replace(last, ticks=last.ticks + 1, change=change, held_back=held_back)
        self._is_open, self._last = repair.intervened, (time, repair.change)
        return begins

    def _weigh_last(self, time: float) -> None:
        then, change = self._last
        extra = time - then - INTERVAL
        if time <= then or math.isclose(extra, 0.0, abs_tol=_SAME):
            return
        spell = self._spells[-1]
        self._spells[-1] = replace(
            spell, change=spell.change + change * (extra / INTERVAL), extra_time=spell.extra_time + extra
        )

    @property
    def spells(self) -> tuple[Spell, ...]:
        """Those so far, the last perhaps unfinished."""
        return tuple(self._spells)
