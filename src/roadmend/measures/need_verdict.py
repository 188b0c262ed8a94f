"""Whether an intervention was a rescue or a nuisance, by its need."""

from enum import StrEnum

RESCUE = 0.2  # need from which a spell is called so
NEEDLESS = 0.1  # need below which a spell is called so, or a nuisance


class NeedVerdict(StrEnum):
    """What a spell was."""

    RESCUE = "rescue"
    NUISANCE = "nuisance"
    UNCLEAR = "unclear"  # between the two: it would have gone well, most likely


def verdict_of(need: float | None) -> NeedVerdict | None:
    """What a spell was.

    Args:
        need: share of the futures of its first tick, the policy left alone, that violate; None: not looked at.

    Returns:
        None where nobody has looked.
    """
    if need is None:
        return None
    if need < NEEDLESS:
        return NeedVerdict.NUISANCE
    return NeedVerdict.RESCUE if need >= RESCUE else NeedVerdict.UNCLEAR
