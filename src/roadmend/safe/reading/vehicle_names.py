"""The ways in which reports number vehicles, turned into one: v1, v2, v3."""

import re

_WORDS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_NUMBER = rf"(?:\#|no\.?|number)?\s*\#?\s*(?P<number>{'|'.join(_WORDS)}|[1-9](?!\d|\.\d|,\d{1, 3}\b))"
_KIND = r"(?:vehicle|veh\.?|unit|car|truck|driver|automobile|motorist|operator|v|d)s?"
_NOT_A_NUMBER = (
    r"(?!\s*(?:lane|door|mph|km|%|st\b|nd\b|rd\b|th\b|of\b|hundred|quarter|occupant|other|feet|met(?:er|re)|car|"
    r"passenger|more|seconds?|minutes?|hours?|years?)|-(?!\w*\s*case))"
)
_REFERENCE = re.compile(rf"\b{_KIND}[\s-]*{_NUMBER}\b{_NOT_A_NUMBER}")
_FURTHER = re.compile(
    rf"(v\d(?:'s)?\s*(?:,\s*and|,\s*or|and|or|&|,)\s*){_NUMBER}\b{_NOT_A_NUMBER}(?=\s*(?:,|\.|;|and\b|or\b|\w+ed\b|"
    r"were\b|\w+\s+\w+))"
)
_LETTER = re.compile(r"\b([Vv]ehicle|[Cc]ar|[Uu]nit|VEHICLE|CAR|UNIT) ([A-F])\b(?![\w'/-])")
_ORDINAL = re.compile(r"\b(?:the|a) (first|second|third) (?:vehicle|car|automobile)\b")
_DEFINES_CASE = re.compile(
    r"\bv(\d)\s*[(,;:/=-]*\s*(?:the\s+)?(?:case|subject)[- ]vehicle|(?:case|subject) vehicle\s*,?\s*\(\s*v(\d)"
)
_CASE = re.compile(r"\b(?:the|this) (?:case|subject) vehicle\b(?!\s*\()")


def name_vehicles(text: str) -> str:
    """A text in which every numbered vehicle is called v and its number; the result is in lower case."""
    plain = _LETTER.sub(lambda match: f"v{'ABCDEF'.index(match[2]) + 1}", text).lower()
    plain = _REFERENCE.sub(lambda match: f"v{_value(match['number'])}", plain)
    for _ in _WORDS:  # each turn names one more vehicle of a list
        longer = _FURTHER.sub(lambda match: f"{match[1]}v{_value(match['number'])}", plain)
        if longer == plain:
            break
        plain = longer
    return _ORDINAL.sub(lambda match: f"v{('first', 'second', 'third').index(match[1]) + 1}", plain)


def case_vehicle(plain: str) -> int:
    """Number of the vehicle that a text in plain form calls the case vehicle; 1 where it does not say."""
    match = _DEFINES_CASE.search(plain)
    return int(match[1] or match[2]) if match else 1


def name_case_vehicle(plain: str, number: int) -> str:
    """A text in plain form in which 'the case vehicle' has its number."""
    return _CASE.sub(f"v{number}", plain)


def _value(numeral: str) -> int:
    return int(numeral) if numeral.isdigit() else _WORDS.index(numeral) + 1
