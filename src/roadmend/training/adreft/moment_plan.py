"""Which moments of a drive are looked at and what is tried there, drawn at random from seeds and names."""

import random
from collections.abc import Iterator
from dataclasses import dataclass

from roadmend.core.tick import INTERVAL
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.weighing import MILDEST
from roadmend.training.adreft.trial_plan import Hold

_LATE, _EARLY = 4.0, 8.0  # [s] before a violation: where most happens, and where it begins to show
_BEYOND = 12.0  # [s] after the end of the policy's own drive, for drives that something has slowed down
_SHARES = (0.5, 0.3, 0.2)  # of a violation's moments: late, early, before
_BEYOND_SHARE = 0.3
_GAP = 4.0  # [s] mean between two pulses of a drive
_SHORTEST, _LONGEST = 0.2, 2.0  # [s] of those pulses


@dataclass(frozen=True, slots=True)
class MomentPlan:
    """How much is looked at, and where."""

    moments: int  # of a drive
    futures: int  # of a moment
    actions: int  # tried where some future violates alone
    harmless: float  # probability that one is tried where none does
    pulse: float  # [s] that a tried action is held
    pulsed: int  # drives of a case with pulses at random times
    seed: int
    guide: str = ""  # digest of the model that drives along

    def ticks(self, drive: str, end: float, *, violates: bool, alone: bool) -> dict[int, float]:
        """Numbers of the ticks to look at, each with the time [s] of the drive that it stands for.

        A violation is looked at mostly in its last seconds, so that its moments stand for different times; of the
        others every tick is as likely as any.

        Args:
            drive: name of the drive.
            end: of the policy's own drive [s].
            violates: whether that ends in a violation.
            alone: it is the policy's own; another one may last longer.
        """
        chance = random.Random(f"{self.seed}:{self.guide}{drive}:moments")
        found: dict[int, float] = {}
        strata = list(_strata(round(end / INTERVAL), violates=violates, alone=alone))
        total = sum(share for _, share in strata)
        for ticks, share in strata:
            count = min(len(ticks), max(1, round(self.moments * share / total)))
            found |= dict.fromkeys(chance.sample(ticks, count), len(ticks) * INTERVAL / count)
        return found

    def pulses(self, drive: str, end: float) -> list[Hold]:
        """Pulses at random times of a drive that alone would end at ``end`` [s]."""
        chance = random.Random(f"{self.seed}:{drive}:pulses")
        planned: list[Hold] = []
        begin = chance.expovariate(1.0 / _GAP)
        while begin < end + _BEYOND:
            last = begin + chance.uniform(_SHORTEST, _LONGEST)
            planned.append(Hold(begin, last, chance.randrange(MILDEST, len(ACTIONS))))
            begin = last + chance.expovariate(1.0 / _GAP)
        return planned

    def tried(self, drive: str, tick: int, asked: float, *, dangerous: bool) -> list[int]:
        """Indices into ACTIONS of what to try at a tick.

        Args:
            drive: name of the drive.
            tick: its number.
            asked: the policy's throttle - brake; only harder braking is tried.
            dangerous: whether some future violates without.
        """
        chance = random.Random(f"{self.seed}:{self.guide}{drive}:{tick}:actions")
        if not dangerous and chance.random() >= self.harmless:
            return []
        harder = [index for index, action in enumerate(ACTIONS) if index >= MILDEST and action < asked]
        number = self.actions if dangerous else min(1, self.actions)
        return chance.sample(harder, min(number, len(harder)))


def _strata(ticks: int, *, violates: bool, alone: bool) -> Iterator[tuple[range, float]]:
    """Spans of ticks that are not empty, each with its share of the moments."""
    late, early = (max(0, ticks - round(before / INTERVAL)) for before in (_LATE, _EARLY))
    spans = (range(late, ticks), range(early, late), range(early)) if violates else (range(ticks),)
    for span, share in zip(spans, _SHARES if violates else (1.0,), strict=True):
        if span:
            yield span, share
    if not alone:
        yield range(ticks, ticks + round(_BEYOND / INTERVAL)), _BEYOND_SHARE
