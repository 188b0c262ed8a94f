"""What a report says of its roads beyond the paper's language, so that nothing of it is drawn at random.

Fields of the language come first (``bend``, ``is_divided`` and ``control`` of the road); a file of
one's own may say the same, and more, in extras:

- of the crash: ``x-bend`` ("left" or "right", as vehicle 1 sees it), ``x-median`` (metres, or true for one of a usual
  width), ``x-divided`` (true), ``x-control`` ("signal", "stop sign", "all-way stop", "yield sign" or "none"), and
  ``x-heading`` (point of the compass to which the main road of a merging leads);
- of a vehicle: ``x-lane`` (from the right, 1 is the rightmost; or "left", "middle", "right").

Null says nothing. A file in which one of them holds anything else is refused where it is read (``why_unusable``).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.safe.dsl import Compass, CrashScenario, Side

_MEDIAN = 6.0  # [m] of one whose width nobody says
_WIDEST = 60.0  # [m]
_LEFTMOST = 99  # lane, from the right, of a road as wide as any
_CONTROLS = {
    "traffic light": "traffic_light",
    "signal": "traffic_light",
    "stop sign": "priority_stop",
    "all-way stop": "allway_stop",
    "yield sign": "priority",
    "none": "right_before_left",
}
_PLACES = {"right": 0, "middle": 1, "left": _LEFTMOST}


@dataclass(frozen=True, slots=True)
class _Stated:
    """What a field of one's own may hold that roads are built by."""

    words: str
    holds: Callable[[Any], bool]


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 1


def _is_median(value: Any) -> bool:
    return isinstance(value, bool) or (isinstance(value, int | float) and 0.0 <= value <= _WIDEST)


def _one_of(*words: str) -> _Stated:
    return _Stated(f"one of {', '.join(words)}", lambda value: _plain(value) in {word.lower() for word in words})


_OF_CRASH = {
    "x-bend": _one_of("left", "right"),
    "x-median": _Stated(f"metres from 0 to {_WIDEST:g}, true or false", _is_median),
    "x-divided": _Stated("true or false", lambda value: isinstance(value, bool)),
    "x-control": _one_of(*_CONTROLS),
    "x-heading": _one_of(*Compass),
}
_OF_VEHICLE = {
    "x-lane": _Stated(
        f"a number from 1 at the right, or one of {', '.join(_PLACES)}",
        lambda value: _is_whole(value) or _plain(value) in _PLACES,
    ),
}


def why_unusable(name: str, value: Any, *, of_vehicle: bool) -> str | None:
    """What a field of one's own should hold, in words, where a road is built by it and the value is none of that.

    Args:
        name: of the field.
        value: that it holds; null is never wrong.
        of_vehicle: whether it stands at a vehicle, or at the crash.
    """
    stated = (_OF_VEHICLE if of_vehicle else _OF_CRASH).get(name)
    return None if stated is None or value is None or stated.holds(value) else stated.words


def bend_side(crash: CrashScenario) -> Side | None:
    """To which side the road bends for vehicle 1; None where that is not said."""
    told = crash.road.bend or _word(crash.extras, "x-bend").capitalize()
    return {side.value: side for side in (Side.LEFT, Side.RIGHT)}.get(told)


def median_of(crash: CrashScenario) -> float:
    """What lies between the two directions [m]; 0 where nothing is said to."""
    told = crash.extras.get("x-median")
    if isinstance(told, int | float) and not isinstance(told, bool):
        return min(max(float(told), 0.0), _WIDEST)
    is_divided = crash.road.is_divided or told is True or crash.extras.get("x-divided") is True
    return _MEDIAN if is_divided else 0.0


def control_of(crash: CrashScenario) -> str | None:
    """The junction's control, in the words of a road network; None where it is not said."""
    told = crash.road.control or _word(crash.extras, "x-control")
    return _CONTROLS.get(told.lower())


def main_heading(crash: CrashScenario) -> Compass | None:
    """Where the main road of a merging leads; None where it is not said."""
    word = _word(crash.extras, "x-heading")
    return next((side for side in Compass if side.value.lower() == word), None)


def lanes_of(crash: CrashScenario) -> dict[int, int]:
    """The lane that a vehicle starts on, from 0 at the right, by the vehicle's index, where it is said."""
    found = {}
    for index, vehicle in enumerate(crash.vehicles):
        told = vehicle.extras.get("x-lane")
        if isinstance(told, int) and _is_whole(told):
            found[index] = told - 1
        elif _plain(told) in _PLACES:
            found[index] = _PLACES[_plain(told)]
    return found


def _word(extras: Mapping[str, Any], name: str) -> str:
    return _plain(extras.get(name))


def _plain(value: Any) -> str:
    return value.strip().lower() if isinstance(value, str) else ""
