"""A small space and a made-up world for it, so that techniques are tested without SUMO."""

from roadmend.core.outcome import Blame
from roadmend.search.evaluation import BEST, Evaluation, Trial, parameters_digest
from roadmend.world.space import Choice, Uniform, Whole
from tests.measures.results import episode


def made_up(outcome, digest, fitness, features, blame=Blame.FRONT):
    return Evaluation(episode(outcome, digest=digest, blame=blame), "", fitness, features)


SPACE = {
    "speed": Uniform(0.0, 10.0),
    "lanes": Whole(1, 4),
    "only": Whole(2, 2),
    "kind": Choice({"car": 0.5, "truck": 0.3, "bus": 0.2}),
    "fixed": Choice({True: 1.0}),
    **{f"v{slot}.{name}": Uniform(-5.0, 5.0) for slot in range(4) for name in ("x", "y")},
}


def toy_evaluation(parameters):
    """A valley: violations lie where every other stands near its place; random draws seldom get there."""
    away = sum(abs(parameters[f"v{slot}.{name}"] - slot) for slot in range(4) for name in ("x", "y"))
    away += abs(parameters["speed"] - 7.0) + 2.0 * (parameters["kind"] != "truck")
    fitness = BEST if away < 9.0 else -away
    outcome = "COLLISION" if fitness == BEST else "GOAL"
    features = (parameters["speed"] / 10.0, parameters["v0.x"] / 5.0)
    return made_up(outcome, parameters_digest(parameters), fitness, features)


def toy_evaluator(points):
    return map(toy_evaluation, points)


def drive(technique, budget):
    """All trials of a technique in the toy world."""
    trials = []
    while len(trials) < budget:
        batch = [Trial(point, toy_evaluation(point)) for point in technique.propose()]
        technique.learn(batch)
        trials += batch
    return trials[:budget]
