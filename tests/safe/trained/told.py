"""Told crashes for a small network to learn from."""

import json

TEXT = "A car was northbound on Elm. A van was westbound on Oak and hit the car in the left side. It was raining."
KEY = {
    "road_type": "Intersection",
    "num_lanes": 2,
    "stem_direction": None,
    "vehicles": [
        {"model": "Sedan", "initial_position": "S2N", "action": "Move Forward", "speed_limit_mph": None},
        {"model": "Minivan", "initial_position": "E2W", "action": "Move Forward", "speed_limit_mph": None},
    ],
    "env": {"time": None, "weather": "Rainy"},
    "collisions": [{"striking": 2, "struck": 1, "striking_side": "front", "struck_side": "right"}],
}


def write_told(path, count=6, **changes):
    """Write a file of told crashes, all alike."""
    content = {"text": TEXT, "key": KEY, "called": [["A car", "the car"], ["A van"]]} | changes
    lines = [json.dumps(content | {"author": "ann" if at % 2 else "bob", "name": f"{at:02}"}) for at in range(count)]
    path.write_text("\n".join(lines) + "\n")
    return path
