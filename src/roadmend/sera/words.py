"""Descriptors and patterns in words: for people, and for models that embed sentences."""

from collections import Counter

from roadmend.sera.descriptor import BankEntry, Descriptor, Hazard
from roadmend.sera.pattern import FailurePattern

ROADS = {
    "intersection": "intersection",
    "tee_junction": "T-junction",
    "highway_exit": "highway exit",
    "on_ramp": "on-ramp",
    "road_network": "road network",
}
MANOEUVRES = {
    "left_turn": "turns left",
    "right_turn": "turns right",
    "straight": "crosses straight on",
    "exit": "leaves by the exit",
    "merge": "merges",
    "keep_lane": "keeps to the road",
}
HAZARDS = {
    "cut_in": "cuts in",
    "cut_in_and_brake": "cuts in and brakes",
    "hard_braking": "brakes hard",
    "run_right_of_way": "ignores the right of way",
    "pedestrian_crossing": "crosses the road",
}
SIDES = {
    "ahead": "ahead",
    "behind": "from behind",
    "left": "from the left",
    "right": "from the right",
    "oncoming": "oncoming",
}
CONTROLS = {
    "priority": "priority signs",
    "right_before_left": "right before left",
    "allway_stop": "all-way stop",
    "traffic_light": "traffic light",
}
WEATHERS = {
    "clear": "clear weather",
    "sunny": "sunshine",
    "cloudy": "clouds",
    "overcast": "overcast sky",
    "windy": "wind",
    "rainy": "rain",
    "foggy": "fog",
    "snowy": "snow",
}
LIGHTS = {"daytime": "by day", "nighttime": "at night"}
OUTCOMES = {
    "GOAL": "goal reached",
    "COLLISION": "collision",
    "TIMEOUT": "time-out",
    "OFF_ROUTE": "off the route",
    "ABORTED": "aborted",
}
_KILOMETRES_PER_HOUR = 3.6


def words_of(descriptor: Descriptor) -> str:
    """A descriptor as one line."""
    return "; ".join(part for part in _parts(descriptor) if part)


def _parts(descriptor: Descriptor) -> list[str]:
    road = descriptor.road
    place = ROADS[road.kind]
    if road.control is not None:
        place += f" with {CONTROLS[road.control]}" + (" and crossings" if road.crossings else "")
    size = []
    if road.lanes is not None:
        size.append(f"{road.lanes} lane{'s' if road.lanes != 1 else ''}")
    if road.speed_limit is not None:
        size.append(f"{round(road.speed_limit * _KILOMETRES_PER_HOUR)} km/h")
    present = ", ".join(f"{count} {kind}" for kind, count in descriptor.participants.items())
    hazards = Counter(_hazard(each) for each in descriptor.hazards)
    return [
        place,
        ", ".join(size),
        f"the ego {MANOEUVRES[descriptor.manoeuvre]}" if descriptor.manoeuvre is not None else "",
        f"{descriptor.density} traffic: {present}" if present else "no traffic",
        ", ".join(f"{count} x {text}" if count > 1 else text for text, count in hazards.items()),
        f"{WEATHERS[descriptor.weather]} {LIGHTS[descriptor.light]}",
        *(
            f"{each.policy}/{each.method}: "
            + ", ".join(f"{count} x {OUTCOMES[name]}" for name, count in each.outcomes.items())
            for each in descriptor.outcomes
        ),
        descriptor.notes,
    ]


def _hazard(hazard: Hazard) -> str:
    return f"{hazard.participant} {SIDES[hazard.side] + ' ' if hazard.side is not None else ''}{HAZARDS[hazard.kind]}"


def words_of_pattern(pattern: FailurePattern) -> str:
    """A pattern as one line: its own words, then what its structure says."""
    where, who, why = pattern.where, pattern.who, pattern.why
    conditions = [
        *([OUTCOMES[pattern.what]] if pattern.what is not None else []),
        *([ROADS[where.road]] if where.road is not None else []),
        *([CONTROLS[where.control]] if where.control is not None else []),
        *([f"the ego {MANOEUVRES[why.manoeuvre]}"] if why.manoeuvre is not None else []),
        *([f"{who.driver} driver"] if who.driver is not None else []),
        *([who.participant] if who.participant is not None else []),
        *([SIDES[who.side]] if who.side is not None else []),
        *([HAZARDS[why.hazard]] if why.hazard is not None else []),
        *([f"{where.density} traffic"] if where.density is not None else []),
        *([WEATHERS[where.weather]] if where.weather is not None else []),
        *([LIGHTS[where.light]] if where.light is not None else []),
    ]
    return "; ".join(part for part in (pattern.words, ", ".join(conditions)) if part)


def described(entry: BankEntry) -> dict[str, str]:
    """An entry in a few words, as plain data."""
    return {"name": entry.name, "digest": entry.digest, "origin": entry.origin, "words": words_of(entry.descriptor)}
