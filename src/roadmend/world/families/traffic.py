"""What the families share: slots for other vehicles, and room between those in one lane."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from roadmend.world.drivers import BODIES
from roadmend.world.scenario import Environment
from roadmend.world.scenario_actors import Brake, CutIn, Manoeuvre, RunRightOfWay, Trigger
from roadmend.world.space import Choice, Dimension, Parameters, Uniform

WEATHER: dict[str, Dimension] = {
    "weather": Choice({"clear": 0.3, "cloudy": 0.1, "overcast": 0.1, "rainy": 0.22, "foggy": 0.14, "snowy": 0.14}),
    "time_of_day": Choice({"daytime": 0.65, "nighttime": 0.35}),
}
DRIVER = Choice({"careful": 0.15, "normal": 0.35, "aggressive": 0.3, "reckless": 0.2})


Counts = Mapping[str, tuple[int, int]]  # by density of traffic: the least and the most that are there


def count_of(counts: Counts, parameters: Mapping[str, Any]) -> int:
    """How many slots are filled, the first ones."""
    low, high = counts[str(parameters["density"])]
    return round(low + float(parameters["fill"]) * (high - low))


def slot_manoeuvre(slot: str, weights: dict[str, float]) -> dict[str, Dimension]:
    """Dimensions of a slot's manoeuvre."""
    return {
        f"{slot}.manoeuvre": Choice(dict(weights.items())),
        f"{slot}.cue": Choice({"time": 0.2, "ego": 0.8}),
        f"{slot}.when": Uniform(0.5, 10.0),
        f"{slot}.near": Uniform(6.0, 26.0),
        f"{slot}.strength": Uniform(3.0, 8.0),
        f"{slot}.haste": Uniform(1.0, 1.7),
    }


def manoeuvres(parameters: Parameters, slot: str) -> list[Manoeuvre]:
    """The scripted misbehaviour of a slot."""
    by_time = parameters[f"{slot}.cue"] == "time"
    trigger = (
        Trigger(time=float(parameters[f"{slot}.when"]))
        if by_time
        else Trigger(ego_distance=float(parameters[f"{slot}.near"]))
    )
    match parameters[f"{slot}.manoeuvre"]:
        case "brake":
            return [Brake(when=trigger, deceleration=float(parameters[f"{slot}.strength"]), speed=1.0, hold=2.0)]
        case "cut_in":
            return [CutIn(when=trigger, direction="ego")]
        case "swoop":
            braking = Brake(when=trigger, deceleration=float(parameters[f"{slot}.strength"]), speed=4.0, hold=1.5)
            return [CutIn(when=trigger, direction="ego"), braking]
        case "run":
            return [RunRightOfWay(when=trigger, hold=15.0, haste=float(parameters[f"{slot}.haste"]))]
        case _:
            return []


def environment(parameters: Parameters) -> Environment:
    """Weather and light."""
    return Environment.model_validate({"weather": parameters["weather"], "time_of_day": parameters["time_of_day"]})


@dataclass(frozen=True, slots=True)
class LanePlace:
    """A vehicle in a lane: ``ahead`` is its front bumper's coordinate [m] along the lane, growing forwards."""

    slot: str
    lane: tuple[str, int]
    ahead: float  # [m]
    speed: float  # [m/s]
    length: float  # [m]


def make_room(places: Iterable[LanePlace], fixed: LanePlace | None) -> list[LanePlace]:
    """Spread vehicles of one lane so that none starts inside or hopelessly close to another.

    Vehicles keep their order; those ahead of ``fixed`` (the ego) are pushed forwards, the others backwards.
    """
    result: list[LanePlace] = []
    lanes: dict[tuple[str, int], list[LanePlace]] = {}
    for place in places:
        lanes.setdefault(place.lane, []).append(place)
    for lane, members in lanes.items():
        anchor = fixed if fixed is not None and fixed.lane == lane else None
        members.sort(key=lambda place: place.ahead)
        split = anchor.ahead if anchor is not None else float("inf")
        follower = anchor
        for place in (member for member in members if member.ahead >= split):
            if follower is not None:
                needed = follower.ahead + place.length + _gap(follower.speed, place.speed)
                moved = replace(place, ahead=max(place.ahead, needed))
            else:
                moved = place
            result.append(moved)
            follower = moved
        leader = anchor
        for place in reversed([member for member in members if member.ahead < split]):
            if leader is not None:
                allowed = leader.ahead - leader.length - _gap(place.speed, leader.speed)
                moved = replace(place, ahead=min(place.ahead, allowed))
            else:
                moved = place
            result.append(moved)
            leader = moved
    return result


def _gap(behind: float, before: float) -> float:
    """Room [m] that a follower at speed ``behind`` [m/s] needs to a leader at ``before`` [m/s]."""
    closing = max(0.0, behind - before)
    return 3.0 + 0.6 * behind + closing * closing / 6.0


def body_length(kind: str) -> float:
    """Length of a kind of vehicle [m]."""
    return BODIES[kind].length
