"""Numbers that are written as words."""

import re

_ONES = (
    "zero",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
    "thirteen",
    "fourteen",
    "fifteen",
    "sixteen",
    "seventeen",
    "eighteen",
    "nineteen",
)
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_VALUES = {word: value for value, word in enumerate(_ONES)} | {word: 10 * (i + 2) for i, word in enumerate(_TENS)}

_TEN = "|".join(_TENS)
_ONE = "|".join(sorted(_ONES, key=len, reverse=True))
_NUMERAL = re.compile(rf"\b(?:(?:({_TEN})(?:[ -]({'|'.join(_ONES[1:10])}))?)|({_ONE}))\b")


def numerals_to_digits(text: str) -> str:
    """A text in lower case with 'two' as 2 and 'thirty-five' as 35."""
    return _NUMERAL.sub(_digits, text)


def _digits(match: re.Match[str]) -> str:
    ten, one, alone = match.groups()
    return str(_VALUES[alone]) if alone else str(_VALUES[ten] + _VALUES.get(one, 0))
