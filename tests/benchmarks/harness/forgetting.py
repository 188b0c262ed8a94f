"""What a policy loses by learning: what becomes of ordinary scenarios, and of those that went well before.

Those that went well were chosen by what the old policy made of them, luck included, so that whoever drives them again can
only lose. They are driven twice more by both policies with other random numbers for SUMO's drivers. These change how much
the others dawdle and nothing else, so this takes out the luck of that, which is next to none: the old policy reproduces nearly
all of its successes. The scenarios that are no violations as a whole are chosen by less: half are drawn at random, the others
are what searches found to go well under another policy.
"""

from collections.abc import Sequence
from statistics import fmean

from harness.sera_plan import Evaluated
from roadmend.measures.driving import DrivingMeasures
from roadmend.world.scenario import Scenario

REDRAWS = 2
_SEEDS = 2**31  # a scenario's seed is below
_STRIDE = 1_000_003


def redrawn(evaluated: Sequence[Evaluated], before: Sequence[DrivingMeasures]) -> list[Scenario]:
    """The ordinary scenarios that went well, each ``REDRAWS`` times with other random numbers."""
    return [
        each.scenario.model_copy(update={"seed": (each.scenario.seed + number * _STRIDE) % _SEEDS})
        for each, measures in zip(evaluated, before, strict=True)
        if not each.is_hard and measures.success
        for number in range(1, REDRAWS + 1)
    ]


def forgotten(
    evaluated: Sequence[Evaluated], before: Sequence[DrivingMeasures], after: Sequence[DrivingMeasures]
) -> dict[str, float | int | None]:
    """What became of the scenarios that are no violations, and of those among them that went well before; differences in points."""
    ordinary = [place for place, each in enumerate(evaluated) if not each.is_hard]
    well = [place for place in ordinary if before[place].success]

    def change(places: Sequence[int]) -> float | None:
        return fmean(after[one].driving_score - before[one].driving_score for one in places) if places else None

    return {
        "ordinary": len(ordinary),
        "went_well": len(well),
        "ordinary_change": change(ordinary),
        "driving_score_change": change(well),
        "success_rate_change": 100.0 * fmean(after[one].success for one in well) - 100.0 if well else None,
    }


def forgotten_anew(before: Sequence[DrivingMeasures], after: Sequence[DrivingMeasures]) -> dict[str, float | None]:
    """The same of what went well and was drawn anew: what the old policy scores there, and what the new one has more."""
    if not before:
        return {"redrawn_before": None, "redrawn_change": None}
    old, new = (fmean(one.driving_score for one in measures) for measures in (before, after))
    return {"redrawn_before": old, "redrawn_change": new - old}
