"""A text turned on the compass: the same crash told of a town that lies a quarter turn further round."""

import bisect
import re
from collections.abc import Sequence

_POINTS = ("north", "northeast", "east", "southeast", "south", "southwest", "west", "northwest")  # clockwise
_SHORT = ("n", "ne", "e", "se", "s", "sw", "w", "nw")
_PLACE = {word: at for words in (_POINTS, _SHORT) for at, word in enumerate(words)}
_QUARTER = 2  # points of the compass

_WORD = re.compile(
    r"""
    (?<![A-Za-z'\u2019])(?:
        (?P<between>(?:north|south)(?P<joint>[- ]?)(?:east|west)) (?P<end1>ern(?:ly|er|most)?|bounds?|erly|wards?)?(?![A-Za-z])
      | (?P<point>north|south|east|west) (?P<end2>ern(?:ly|er|most)?|bounds?|erly|wards?|most|side)?(?![A-Za-z])
      | (?P<letter>[NSEW]) (?=/?B(?:D|ND)?(?![A-Za-z]))        # E/B, NB
    )
  | (?<![A-Za-z0-9'\u2019.]) (?P<letters>NE|NW|SE|SW)(?![A-Za-z.])
  | (?<![A-Za-z0-9'\u2019.]) (?-i:(?<![A-Z]\.\ )(?P<alone>[NSEW])) (?=\.?(?:[-/ ,;:)]|$)) (?!\.\ ?[A-Z]\.)  # W on Elm; N-S; but no initials
  | (?-i:(?<=[NSEW]-)(?P<last>[NSEW])) (?![A-Za-z])
    """,
    re.VERBOSE | re.IGNORECASE,
)


def turn_text(text: str, places: Sequence[tuple[int, int]], quarters: int) -> tuple[str, list[tuple[int, int]]]:
    """A text whose points of the compass lie so many quarter turns further clockwise, and where places in it then are.

    Only words for points of the compass change; what hangs on them without naming one, as the morning sun, does not.

    Args:
        text: of a crash.
        places: pieces of it, each the characters from its start up to, not including, its end.
        quarters: turns, clockwise; none leaves all as it is.
    """
    if quarters % 4 == 0:
        return text, [*places]
    parts, ends, shifts, last = list[str](), [0], [0], 0
    for match in _WORD.finditer(text):
        group = next(name for name in ("between", "point", "letter", "letters", "alone", "last") if match[name])
        start, end = match.span(group)
        word = _turned(match[group], match["joint"] or "", quarters)
        parts += [text[last:start], word]
        last = end
        ends.append(end)
        shifts.append(shifts[-1] + len(word) - (end - start))

    def moved(place: int) -> int:
        return place + shifts[bisect.bisect_right(ends, place) - 1]

    return "".join([*parts, text[last:]]), [(moved(start), moved(end)) for start, end in places]


def _turned(word: str, joint: str, quarters: int) -> str:
    names = _SHORT if len(word) <= len("ne") else _POINTS
    low = word.lower().replace(joint, "") if joint else word.lower()
    found = names[(_PLACE[low] + _QUARTER * quarters) % len(names)]
    if joint:
        middle = len("north")  # of both halves of "northeast" the first one's length
        found = found[:middle] + joint + found[middle:]
    if word.isupper():
        return found.upper()
    if not word[0].isupper():
        return found
    parts = found.split(joint) if joint else [found]
    return joint.join([parts[0].capitalize(), *(each.capitalize() if word.istitle() else each for each in parts[1:])])
