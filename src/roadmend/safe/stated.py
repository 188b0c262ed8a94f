"""What a report says of its roads beyond the paper's language, so that nothing of it is drawn at random.

Fields of the language come first (``bend``, ``is_divided`` and ``control`` of the road); a file of
one's own may say the same, and more, in extras:

- of the crash: ``x-bend`` ("left" or "right", as vehicle 1 sees it), ``x-median`` (metres, or true for one of a usual
  width), ``x-divided`` (true), ``x-control`` ("signal", "stop sign", "all-way stop", "yield sign" or "none"), and
  ``x-heading`` (point of the compass to which the main road of a merging leads);
- of a vehicle: ``x-lane`` (from the right, 1 is the rightmost; or "left", "middle", "right").
"""

from collections.abc import Mapping
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
        if isinstance(told, int) and not isinstance(told, bool) and told >= 1:
            found[index] = told - 1
        elif isinstance(told, str):
            place = {"right": 0, "middle": 1, "left": _LEFTMOST}.get(told.strip().lower())
            if place is not None:
                found[index] = place
    return found


def _word(extras: Mapping[str, Any], name: str) -> str:
    told = extras.get(name)
    return told.strip().lower() if isinstance(told, str) else ""
