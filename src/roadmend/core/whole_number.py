"""Whole numbers that somebody gives in Python: of a seed, of how many."""

import operator

from roadmend.core.errors import InputError


def whole_number(where: str, given: object, least: int = 0) -> int:
    """A number that counts something; numpy's will do.

    Raises:
        InputError: it is none, or below ``least``.
    """
    try:
        number = operator.index(given)  # type: ignore[arg-type] # that is what is asked
    except TypeError:
        number = least - 1
    if isinstance(given, bool) or number < least:
        raise InputError(where, f"{given!r} is no whole number from {least}", "give for instance 7")
    return number
