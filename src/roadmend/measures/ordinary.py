"""What repair costs where nothing was wrong: drives in which the policy alone does not collide by its own fault.

A drive that goes on to the goal or the time limit without repair, and with it ends before - in a collision, off the lane,
or given up - has won no time and lost no way by it. It is counted as cut short, and in neither loss.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean, median

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.outcome import EventKind
from roadmend.measures.need_verdict import NEEDLESS, RESCUE

TOUCH = 0.2  # [s] of full command from which a drive counts as touched
_WHOLE = (EventKind.GOAL, EventKind.TIMEOUT)  # ends of drives whose time and way can be compared


@dataclass(frozen=True, slots=True)
class OrdinaryFigures:
    """What a method costs in ordinary drives; shares in percent, None where no drive tells."""

    drives: int  # in which the policy alone does not violate
    untouched: float | None  # [%] of them whose dose is below TOUCH, and in which no lane change was held back
    time_lost: float | None  # [%] mean over those that the policy alone brings to the goal, if not cut short now
    time_lost_median: float | None  # [%] likewise, the median
    distance_lost: float | None  # [%] mean over those that the time limit ends, if not cut short now
    needless_dose_per_hour: (
        float | None
    )  # [s/h] in spells whose need is below NEEDLESS; None where it was not looked at
    needless_dose_per_km: float | None  # [s/km]
    spells_per_km: float | None
    spells_needed: float | None  # [%] of the spells of all drives whose need is RESCUE or more; None: not looked at
    mean_jerk: float | None  # [m/s3]
    collisions_bare: int  # of all drives, by the ego's own fault, the policy left alone
    collisions: int  # likewise, with the method
    new_collisions: int  # by the ego's own fault where the policy alone has none
    cut_short: int  # of those that go on to the goal or the time limit alone: now end before, whosever fault it is
    struck_bare: int  # collisions of all drives whosever fault, the policy left alone; a standing ego is hit by others
    struck: int  # likewise, with the method


def ordinary_figures(pairs: Sequence[tuple[EpisodeResult, EpisodeResult]]) -> OrdinaryFigures:
    """The figures of the same drives, each by the policy alone and with the method."""
    calm = [(bare, own) for bare, own in pairs if not bare.final.at_fault]
    whole = [(bare, own) for bare, own in calm if bare.outcome in _WHOLE and own.outcome in _WHOLE]
    to_goal = [own.duration / bare.duration - 1.0 for bare, own in whole if bare.reached_goal]
    in_time = [1.0 - own.distance / bare.distance for bare, own in whole if bare.timed_out and bare.distance > 0.0]
    hours = sum(own.duration for _, own in calm) / 3600.0
    kilometres = sum(own.distance for _, own in calm) / 1000.0
    spells = [spell for _, own in calm for spell in own.spells]
    needs = [spell.need for _, own in pairs for spell in own.spells]
    needless: float | None = None
    if all(spell.need is not None for spell in spells):
        needless = sum(spell.dose for spell in spells if spell.need is not None and spell.need < NEEDLESS)
    return OrdinaryFigures(
        len(calm),
        _percent([own.dose < TOUCH and not own.held_back for _, own in calm]),
        _percent(to_goal),
        100.0 * median(to_goal) if to_goal else None,
        _percent(in_time),
        None if needless is None or not hours else needless / hours,
        None if needless is None or not kilometres else needless / kilometres,
        len(spells) / kilometres if kilometres else None,
        None if None in needs else _percent([need >= RESCUE for need in needs if need is not None]),
        fmean(own.mean_jerk for _, own in calm) if calm else None,
        sum(bare.final.at_fault for bare, _ in pairs),
        sum(own.final.at_fault for _, own in pairs),
        sum(own.final.at_fault for _, own in calm),
        sum(bare.outcome in _WHOLE for bare, _ in calm) - len(whole),
        sum(bare.collided for bare, _ in pairs),
        sum(own.collided for _, own in pairs),
    )


def _percent(values: Sequence[float]) -> float | None:
    return 100.0 * fmean(values) if values else None
