"""An episode is the same to the bit whatever its process did before, and in whatever process it runs."""

import math
import random
import sys
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Pedestrian

sys.path.append(str(Path(__file__).parent))  # worker processes get it from here and import both by name
import physics
import processes

SEEDS = 8  # scenarios of each family
TIME_LIMIT = 2.0  # [s]
WAYS = (("modular", "none"), ("modular", "predictive"), ("neural", "rss"), ("neural", "adreft"), ("modular", "random"))


def scenarios(family):
    """The first that are settled, cut short."""
    drawn = (sample_scenario(family, seed) for seed in range(1000))
    settled = (scenario for scenario in drawn if physics.is_settled(scenario))
    return [scenario.model_copy(update={"time_limit": TIME_LIMIT}) for scenario in islice(settled, SEEDS)]


def episodes():
    """200: eight scenarios of each family, each driven in five ways."""
    return [
        physics.Golden(f"{scenario.name}-{policy}-{method}", scenario, policy, method)
        for family in FAMILIES
        for scenario in scenarios(family)
        for policy, method in WAYS
    ]


def shuffled(seed):
    return random.Random(seed).sample(episodes(), 200)


def by_name(driven, records):
    return {episode.name: record for episode, record in zip(driven, records, strict=True)}


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_200_episodes_are_the_same_in_one_process_in_fresh_ones_and_in_workers():
    first, second, third = shuffled(1), shuffled(2), shuffled(3)
    expected = by_name(first, processes.drive_in_one(first, seed=4))
    assert len(expected) == 200
    assert len({record["scenes"] for record in expected.values()}) > 40  # a scenario differs by who drives in it
    assert sum(record["interventions"] > 0 for record in expected.values()) > 50
    for driven, records in (
        (second, processes.drive_in_fresh(second)),
        (third, processes.drive_in_workers(third, 2)),
    ):
        found = by_name(driven, records)
        moved = {name: physics.difference(expected[name], found[name]) for name in expected}
        assert {name: change for name, change in moved.items() if change} == {}


def test_a_run_that_is_not_the_same_is_told_apart():
    episode = next(each for each in episodes() if each.name.startswith("S5") and each.method == "none")
    short = replace(episode, scenario=episode.scenario.model_copy(update={"time_limit": 1.0}))
    kept = physics.drive(short)
    assert physics.difference(kept, physics.drive(short)) == ""
    ego = short.scenario.ego
    faster = ego.model_copy(update={"speed": math.nextafter(ego.speed, math.inf)})
    found = physics.drive(replace(short, scenario=short.scenario.model_copy(update={"ego": faster})))
    assert "trajectory" in physics.difference(kept, found)


def test_only_reckless_drivers_among_pedestrians_are_left_out():
    drawn = [sample_scenario(family, seed) for family in FAMILIES for seed in range(20)]
    left_out = [scenario for scenario in drawn if not physics.is_settled(scenario)]
    assert 0 < len(left_out) < 0.3 * len(drawn)
    for scenario in left_out:
        assert sum(isinstance(actor, Pedestrian) for actor in scenario.actors) >= 2
        assert any(getattr(actor, "driver", "") == "reckless" for actor in scenario.actors)
