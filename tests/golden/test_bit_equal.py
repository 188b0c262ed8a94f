"""An episode is the same to the bit whatever its process did before, and in whatever process it runs."""

import math
import random
import sys
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

from roadmend.world.families import FAMILIES, sample_scenario

sys.path.append(str(Path(__file__).parent))  # worker processes get it from here and import both by name
import physics
import processes

SEEDS = 8  # scenarios of each family
TIME_LIMIT = 2.0  # [s]
WAYS = (("modular", "none"), ("modular", "predictive"), ("neural", "rss"), ("neural", "adreft"), ("modular", "random"))
CROWDED = 4  # scenarios of each family with pedestrians in which reckless drivers meet several of them, whole
TOLD_APART = ("S1", 138)  # of 210 such scenarios the one that went otherwise while SUMO drew whom a driver heeds


def scenarios(family):
    """The first, cut short."""
    drawn = (sample_scenario(family, seed) for seed in range(SEEDS))
    return [scenario.model_copy(update={"time_limit": TIME_LIMIT}) for scenario in drawn]


def crowded():
    """Those in which SUMO would draw random numbers in the order of pointers, did a driver not know whom it heeds."""
    drawn = [(sample_scenario(family, seed) for seed in range(1000)) for family in ("S1", "S2", "S3")]
    chosen = [scenario for each in drawn for scenario in islice(filter(physics.is_crowded, each), CROWDED)]
    chosen += [sample_scenario(*TOLD_APART)] * 8  # under other names: one is not enough to be sure of a difference
    return [
        physics.Golden(f"{scenario.name}-crowded-{place}", scenario, *WAYS[0]) for place, scenario in enumerate(chosen)
    ]


def episodes():
    """Eight scenarios of each family, each driven in five ways, and twenty crowded ones: 220."""
    return [
        physics.Golden(f"{scenario.name}-{policy}-{method}", scenario, policy, method)
        for family in FAMILIES
        for scenario in scenarios(family)
        for policy, method in WAYS
    ] + crowded()


def shuffled(seed):
    every = episodes()
    return random.Random(seed).sample(every, len(every))


def by_name(driven, records):
    return {episode.name: record for episode, record in zip(driven, records, strict=True)}


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_220_episodes_are_the_same_in_one_process_in_fresh_ones_and_in_workers():
    first, second, third = shuffled(1), shuffled(2), shuffled(3)
    expected = by_name(first, processes.drive_in_one(first, seed=4))
    assert len(expected) == 220
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
