"""A policy that sees nobody and so drives into somebody often enough, and a corpus of what it comes to."""

import random
from functools import cache

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.parameters import NoParameters
from roadmend.policies.registry import PolicyEntry
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import Case, Corpus
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.runner import run_episode
from roadmend.world.space import sample

PACE = 9.0  # [m/s]
SUSPECTS = (31, 32, 41, 43, 46, 48, 52, 53, 58, 69, 72, 74, 76, 78, 81, 85, 88, 95, 98, 102, 105, 109, 111, 112)


class BlindPolicy:
    """Holds its pace along the route."""

    name = "blind"

    def __init__(self, _values=None):
        pass

    def reset(self, route):
        pass

    def step(self, scene):
        return Decision(Command(0.5 if scene.ego.speed < PACE else 0.05, 0.0), Trajectory.empty())


ENTRY = PolicyEntry(NoParameters, BlindPolicy)  # for the table of policies


@cache
def _case(seed):
    scenario = sample_scenario("S3", seed)
    summary = run_episode(scenario, BlindPolicy(), make_repairer("none"))
    parameters = sample(FAMILIES["S3"].space, random.Random(f"roadmend/S3/{seed}"))
    return Case(
        scenario.name,
        "S3",
        "training",
        seed,
        parameters,
        summary.outcome.name,
        summary.digest,
        "random",
        0,
        seed,
        summary.text,
        summary.min_distance,
        summary.duration,
    )


def blind_corpus(training, validation):
    """A corpus of crossings with so many violations and as many successes in both splits."""
    cases = []
    for outcome, seeds in (("COLLISION", (*SUSPECTS, *range(120, 400))), ("GOAL", range(400))):
        found = (case for case in map(_case, seeds) if case.outcome == outcome)
        for split, number in (("training", training), ("validation", validation)):
            cases += [Case(**{**vars(next(found)), "split": split}) for _ in range(number)]
    return Corpus("blind", tuple(cases))
