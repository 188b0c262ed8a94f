"""What the words for a vehicle's manoeuvre mean to the scene, whoever wrote them: by their stems, in any case."""

import re

_STANDS = re.compile(r"\b(stop|stopped|stopping|park|parked|standing|stationary)\b")
_LEFT = re.compile(r"\b(left)\b")
_RIGHT = re.compile(r"\b(right)\b")
_SIDEWAYS = re.compile(r"\b(chang\w* lanes?|lane chang\w*|drift\w*|merg\w*|overtak\w*|pass(es|ing)?|swerv\w*|cut\w*)\b")
_DRIVEWAY = re.compile(r"\bdriveway\b")
_WRONG_WAY = re.compile(r"\bwrong way\b|\bovertak\w*|\bdrift\w*|\bcross\w*( the)?( cent\w+)\b|\bover the cent\w+\b")
_RUNS_OFF = re.compile(r"\brun\w*.?off\b|\bleav\w*( the)? road\b")
_U_TURN = re.compile(r"\bu.?turn\w*\b")
_BACKWARDS = re.compile(r"\b(revers\w*|back(ing|ed|s)?( up| out)?)\b")


def stands(words: str | None) -> bool:
    """Whether the vehicle had stopped, or was parked."""
    return _said(_STANDS, words)


def comes_sideways(words: str | None) -> bool:
    """Whether it leaves its lane for the next one."""
    return _said(_SIDEWAYS, words)


def crosses_over(words: str | None) -> bool:
    """Whether it comes onto the half of the road that is for the others."""
    return _said(_WRONG_WAY, words)


def runs_off(words: str | None) -> bool:
    """Whether it leaves the road."""
    return _said(_RUNS_OFF, words)


def leaves_driveway(words: str | None) -> bool:
    """Whether it comes from a property."""
    return _said(_DRIVEWAY, words)


def turns_round(words: str | None) -> bool:
    """Whether it makes a U-turn."""
    return _said(_U_TURN, words)


def goes_backwards(words: str | None) -> bool:
    """Whether it reverses."""
    return _said(_BACKWARDS, words)


def to_the_left(words: str | None) -> bool | None:
    """Of a vehicle that goes sideways, whether it goes left; None where the words do not say, or it does not."""
    if not comes_sideways(words):
        return None
    if _said(_LEFT, words) == _said(_RIGHT, words):
        return None
    return _said(_LEFT, words)


def _said(pattern: re.Pattern[str], words: str | None) -> bool:
    return words is not None and pattern.search(words.lower()) is not None
