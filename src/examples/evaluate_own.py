"""A policy and a repair method of one's own, measured beside ours: the table, and a page for a browser.

.venv/bin/python src/examples/evaluate_own.py      # the page needs ./roadmend set-up reports
"""

from cruise import Cruise
from late_brake import LateBrake

from roadmend import Scenario, evaluate, sample_scenario


def main(scenarios: list[Scenario], folder: str = "evaluated", workers: int = 2) -> None:
    """Measure in some scenarios; finished episodes are kept in the folder, the page too."""
    found = evaluate(scenarios, Cruise, [LateBrake, "rss"], folder=folder, workers=workers)
    print(found)
    print(found.save(folder))


if __name__ == "__main__":
    main([sample_scenario(family, number) for family in ("S3", "S4") for number in range(5)])
