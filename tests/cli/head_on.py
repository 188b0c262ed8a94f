"""A crash report of two cars that meet head-on, and what is to be read in it."""

from PIL import Image

HEAD_ON = {
    "road_type": "Straight",
    "num_lanes": 2,
    "stem_direction": None,
    "vehicles": [
        {"model": "Sedan", "initial_position": "W2E", "action": "Move Forward", "speed_limit_mph": 35},
        {
            "model": "SUV",
            "initial_position": "E2W",
            "action": "Move Forward",
            "speed_limit_mph": 35,
            "manoeuvre": "Enter the Wrong Way",
        },
    ],
    "env": {"time": "Daytime", "weather": None},
}
SUMMARY = (
    "Vehicle one, a 2001 Ford Taurus four-door sedan, was traveling east on a straight two-lane road. Vehicle two, a "
    "2003 Dodge Ram pickup truck, was traveling west on the same road. It was daylight and the weather was clear. The "
    "posted speed limit was 35 mph. Vehicle two crossed the centerline and its front struck the front of Vehicle one."
)


def write_report(reports):
    """Write it into a folder of reports, and return that."""
    folder = reports / "head-on"
    folder.mkdir(parents=True)
    (folder / "summary.txt").write_text(SUMMARY, encoding="utf-8")
    Image.new("RGB", (40, 30), "white").save(folder / "sketch.png")
    return reports
