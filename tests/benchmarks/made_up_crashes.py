"""Crash scenes drawn from a seed, for people to write crash texts about.

    python tests/benchmarks/made_up_crashes.py --seed 4107 --count 90 > scenes.json

A scene is only a starting point: each text in `crash_texts/` was written by hand from one, and its oracle says what the
text says. There null means that the text leaves the fact out, and `alternatives` lists by path what else a careful
reader may say. Vehicles are numbered from 1, in the order of the text. Sides (front, rear, left, right) follow from the
headings, for traffic that keeps to the right; where nothing but a fixed object is struck, there are no collisions.
"""

import argparse
import json
import random
from typing import Any

Vehicle = dict[str, Any]
Hit = tuple[int, int, str, str]  # striking and struck vehicle, counted from 1, and the side of each

COMPASS = ["N2S", "E2W", "S2N", "W2E"]  # each heading is the one before it turned right by a quarter
SIDE_NAMES = {"N2S": "South", "E2W": "West", "S2N": "North", "W2E": "East"}
REGISTERS = ["insurance claim", "news", "police shorthand", "witness", "dispatch or forum", "European"]
MODELS = ["Sedan", "Sedan", "Sedan", "SUV", "SUV", "Minivan", "Pickup", "Pickup", "Semi Truck"]
DAY_WEATHER = ["Sunny", "Sunny", "Sunny", "Cloudy", "Overcast", "Rainy", "Snowy", "Foggy", "Windy"]
NIGHT_WEATHER = ["Clear", "Clear", "Clear", "Cloudy", "Rainy", "Rainy", "Snowy", "Foggy", "Windy"]
MPH = {1: [20, 25], 2: [25, 30, 35, 40, 45, 55], 3: [30, 35, 45], 4: [35, 40, 45, 50, 55], 5: [40, 45], 6: [50, 65, 70]}
KMH = {1: [30], 2: [30, 50, 70, 80, 90], 3: [50, 70], 4: [70, 80, 100], 5: [70, 80], 6: [100, 120, 130]}
LANES = {
    "Straight": [2, 2, 2, 3, 4, 4, 5, 6],
    "Curve": [1, 2, 2, 2, 2, 4],
    "Intersection": [2, 2, 2, 3, 4, 4, 5, 6],
    "T-intersection": [2, 2, 2, 3, 4],
    "Merging": [4, 4, 6],
}
# How it happened, by the road it happens on. "stem" crashes begin in the stem of a T.
HAPPENINGS = {
    "Straight": ["rear-end", "head-on", "opposite sideswipe", "lane change", "parked", "reverse", "u-turn", "driveway",
                 "chain", "alone"],
    "Curve": ["head-on", "head-on", "opposite sideswipe", "rear-end", "alone"],
    "Intersection": ["crossing", "crossing", "left turn across", "left turn across", "right turn", "rear-end", "third"],
    "T-intersection": ["stem left", "stem left", "stem right", "left turn across", "rear-end", "alone"],
    "Merging": ["merge sideswipe", "merge struck", "merge behind"],
}  # fmt: skip


def turned(heading: str, quarters: int) -> str:
    """The heading after so many quarter turns to the right."""
    return COMPASS[(COMPASS.index(heading) + quarters) % 4]


def happen(rng: random.Random, kind: str, heading: str) -> tuple[list[tuple[str, str, str]], list[Hit]]:
    """Heading, action and manoeuvre of each vehicle, and who struck whom, for one kind of crash."""
    ahead, left, right = "Move Forward", "Turn Left", "Turn Right"
    going = (heading, ahead, "move forward")
    oncoming = (turned(heading, 2), ahead, "move forward")
    stopped = (heading, ahead, "stop")
    from_left = rng.random() < 0.5
    crossing = (turned(heading, 1 if from_left else 3), ahead, "move forward")
    struck, other = ("left", "right") if from_left else ("right", "left")
    drift = (heading, ahead, "drift over the centre line")
    change = (heading, ahead, "change lane")
    out = left if rng.random() < 0.5 else right
    scenes: dict[str, tuple[list[tuple[str, str, str]], list[Hit]]] = {
        "rear-end": ([going, rng.choice([stopped, going])], [(1, 2, "front", "rear")]),
        "head-on": ([drift, oncoming], [(1, 2, "front", "front")]),
        "opposite sideswipe": ([drift, oncoming], [(1, 2, "left", "left")]),
        "lane change": ([change, going], [(1, 2, "right", "left") if from_left else (1, 2, "left", "right")]),
        "parked": ([going, (heading, ahead, "parked")], [(1, 2, "front", "rear")]),
        "reverse": ([(heading, ahead, "reverse"), stopped], [(1, 2, "rear", "front")]),
        "u-turn": (
            [(heading, left, "u-turn"), going if from_left else oncoming],
            [(2, 1, "front", "left" if from_left else "right")],
        ),
        "driveway": ([(heading, out, "leave driveway"), (turned(heading, 1), ahead, "move forward")],
                     [(2, 1, "front", "left")]),
        "chain": ([going, stopped, stopped], [(1, 2, "front", "rear"), (2, 3, "front", "rear")]),
        "alone": ([rng.choice([going, drift])], []),
        "crossing": ([going, crossing], [(2, 1, "front", struck)]),
        "third": ([going, crossing, (turned(crossing[0], 2), ahead, "stop")],
                  [(2, 1, "front", struck), (1, 3, other, "front")]),
        "left turn across": (
            [(heading, left, "turn left"), oncoming],
            [rng.choice([(2, 1, "front", "right"), (1, 2, "front", "left")])],
        ),
        "right turn": ([(heading, right, "turn right"), going], [rng.choice([(2, 1, "front", "right"), (1, 2, "right", "left")])]),
        "stem left": ([(heading, left, "turn left"), crossing], [(2, 1, "front", struck)]),
        "stem right": ([(heading, right, "turn right"), (turned(heading, 1), ahead, "move forward")],
                       [(2, 1, "front", "left")]),
        "merge sideswipe": ([("On-ramp", ahead, "merge"), ("Main road", ahead, "move forward")], [(1, 2, "left", "right")]),
        "merge struck": ([("On-ramp", ahead, "merge"), ("Main road", ahead, "move forward")],
                         [(2, 1, "front", rng.choice(["rear", "left"]))]),
        "merge behind": ([("On-ramp", ahead, "merge"), ("On-ramp", ahead, "stop")], [(1, 2, "front", "rear")]),
    }  # fmt: skip
    return scenes[kind]


def draw(seed: int, index: int) -> dict[str, Any]:
    """One scene: the same for the same seed and index."""
    rng = random.Random(f"{seed}/{index}")
    register = REGISTERS[index % len(REGISTERS)]
    road = rng.choice(list(HAPPENINGS))
    kind = rng.choice(HAPPENINGS[road])
    heading = rng.choice(COMPASS)
    lanes = rng.choice(LANES[road])
    if kind in {"opposite sideswipe", "head-on"}:
        lanes = max(lanes, 2)
    elif kind == "lane change":
        lanes = max(lanes, 4)
    parts, hits = happen(rng, kind, heading)
    stem = None
    if road == "T-intersection":
        # Out of the stem, or onto it by a left turn, or into its far side: the stem lies behind or to the left.
        behind = kind.startswith("stem") or kind == "alone"
        stem = SIDE_NAMES[turned(heading, 2 if behind else 3)]
    metric = register == "European"
    limit = rng.choice((KMH if metric else MPH)[lanes])
    time = rng.choice(["Daytime", "Daytime", "Nighttime"])
    return {
        "scene": {"seed": seed, "index": index},
        "register": register,
        "rough": rng.random() < 1 / 3,  # typing errors, no capitals, run-on sentences
        "brands": rng.random() < 0.5,  # makes and models for class names
        "kind": kind,
        "road_type": road,
        "num_lanes": lanes,
        "stem_direction": stem,
        "vehicles": [
            {"model": rng.choice(MODELS), "initial_position": place, "action": action, "manoeuvre": manoeuvre}
            for place, action, manoeuvre in parts
        ],
        "speed_limit_kmh": limit if metric else None,
        "speed_limit_mph": round(limit / 1.609344) if metric else limit,
        "env": {"time": time, "weather": rng.choice(DAY_WEATHER if time == "Daytime" else NIGHT_WEATHER)},
        "collisions": [
            dict(zip(["striking", "struck", "striking_side", "struck_side"], hit, strict=True)) for hit in hits
        ],
    }


def main() -> None:
    """Write scenes as JSON to standard output."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=4107)
    parser.add_argument("--count", type=int, default=90)
    options = parser.parse_args()
    print(json.dumps([draw(options.seed, index) for index in range(options.count)], indent=2))


if __name__ == "__main__":
    main()
