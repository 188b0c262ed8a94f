"""Evaluates one point of a family's parameter space: runs it and says how near it came to a violation."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from roadmend.core.command import Decision
from roadmend.core.repair import Repair
from roadmend.core.tick import INTERVAL, Tick
from roadmend.measures.answering import Answering
from roadmend.measures.fitting import fitting
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.search.attempt import Attempt, fault_of
from roadmend.search.behaviour import FEATURES, BehaviourRecorder
from roadmend.search.danger import Danger
from roadmend.world.families import family_of
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario
from roadmend.world.space import Parameters

BEST = 0.0  # fitness of a violation; that of everything else is below
BLAMELESS_FITNESS = -5.0  # of a collision that is not the ego's fault: as good as passing at 5 m
CRASH_FITNESS = -100.0  # below that of every episode


@dataclass(frozen=True, slots=True)
class Subject:
    """What is searched: the points of a family, driven by a policy under a repair method."""

    family: str
    policy: str
    method: str
    seed: int  # of the traffic, the same at every point: only the parameters make the difference

    def __post_init__(self) -> None:
        """Check the names.

        Raises:
            InputError: there is no such family, policy or method.
        """
        family_of(self.family)
        make_policy(self.policy)
        make_repairer(self.method)

    @property
    def repair(self) -> dict[str, Any]:
        """What the method takes instead of its defaults: the model and the settings that were made for the policy."""
        return fitting(self.method, self.policy)

    def scenario(self, parameters: Parameters, name: str) -> Scenario:
        """The scenario that a point stands for."""
        return family_of(self.family).build(parameters, name, self.seed)


class NamedPoint(NamedTuple):
    """A point to evaluate, under the name with which its scenario is kept: methods that draw numbers go by that."""

    name: str
    parameters: Parameters


@dataclass(frozen=True, slots=True)
class Evaluation(Attempt):
    """What a point came to, and what a search makes of that."""

    fitness: float  # of a collision see above, else - (distance + weighted time to collision) at the worst moment [m]
    features: tuple[float, ...]  # the ego's behaviour, see BehaviourRecorder.features

    @property
    def is_violation(self) -> bool:
        """Whether the ego collided by its own fault."""
        return self.result is not None and self.result.collided and self.result.final.at_fault


@dataclass(frozen=True, slots=True)
class Trial:
    """A point and what it came to."""

    parameters: Parameters
    evaluation: Evaluation

    @property
    def fitness(self) -> float:
        """The evaluation's fitness."""
        return self.evaluation.fitness


def parameters_digest(parameters: Parameters) -> str:
    """SHA-256 of a point, hexadecimal."""
    return hashlib.sha256(json.dumps(parameters, sort_keys=True).encode()).hexdigest()


def evaluate_scenario(
    scenario: Scenario, policy: str, method: str, repair: Mapping[str, Any] | None = None
) -> Evaluation:
    """Run a scenario in this process.

    Args:
        scenario: what to run.
        policy: name of the policy.
        method: name of the repair method.
        repair: what differs from the method's defaults.

    Raises:
        InputError: the scenario cannot be run, there is no such policy or method, or a parameter is unusable.
        SimulationError: SUMO failed.
        RoadmendError: the method could not answer, so that the guard's rule did.
    """
    danger, behaviour = Danger(), BehaviourRecorder(INTERVAL)

    def watch(tick: Tick, _decision: Decision, _repair: Repair) -> None:
        danger.watch(tick.scene)
        behaviour.watch(tick.scene.ego)

    result = run_episode(scenario, make_policy(policy), Answering(make_repairer(method, repair)), watch)
    fitness = min(BEST - 1e-6, -danger.least)
    if result.collided:
        fitness = BEST if result.final.at_fault else BLAMELESS_FITNESS
    return Evaluation(result, "", fitness, behaviour.features())


def evaluate(subject: Subject, point: NamedPoint, repair: Mapping[str, Any] | None = None) -> Evaluation:
    """Build and run a point; an error that it causes is a result here, since the next search would meet it again.

    ``repair`` is what differs from what the repair method takes behind the policy.

    Raises:
        RoadmendError: the machine failed, see ``fault_of``.
    """
    try:
        scenario = subject.scenario(point.parameters, point.name)
        return evaluate_scenario(scenario, subject.policy, subject.method, subject.repair | dict(repair or {}))
    except Exception as error:  # noqa: BLE001 - see above
        return Evaluation(None, fault_of(error), CRASH_FITNESS, (0.0,) * FEATURES)
