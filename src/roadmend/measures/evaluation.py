"""Evaluation: policies times repair methods times scenarios are driven; ``evaluation_figures`` says what they are worth."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import SimulationError
from roadmend.core.fanout import fan_out
from roadmend.core.interfaces import Policy
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.answering import Answering
from roadmend.measures.driver import driver_key
from roadmend.measures.fitting import fitting
from roadmend.measures.need import run_with_need
from roadmend.policies.registry import make_policy
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import outside_content

FORMAT = "roadmend-evaluation-work/1"  # of the journal of finished episodes
ALONE = "none"  # the method that never steps in: what the others are held against
TRIVIAL = (ALONE, "random")


@dataclass(frozen=True, slots=True)
class EvaluationTrial:
    """One episode to be driven; travels to other processes by pickle."""

    scenario: Scenario
    policy: str  # name or model file
    method: str
    driver: Key  # see ``measures.driver``
    futures: int = 0  # by which the need of every spell is told; 0: not told
    parameters: Mapping[str, Any] = field(default_factory=dict)  # what differs from the method's defaults
    title: str = ""  # under which the method is told; its name where empty

    @property
    def told_as(self) -> str:
        """What the method is called in figures."""
        return self.title or self.method

    @property
    def key(self) -> Key:
        """Of all that decides what comes out."""
        scenario = self.scenario
        decided = scenario.name, scenario.digest, outside_content(scenario)
        return entry_key([__name__], *decided, self.driver, self.futures)


@dataclass(frozen=True, slots=True)
class Driven:
    """What a trial came to, or why there is nothing."""

    trial: EvaluationTrial
    result: EpisodeResult | None = None
    fault: str = ""


def trials_of(
    scenarios: Sequence[Scenario],
    policies: Sequence[str],
    methods: Sequence[str],
    futures: int = 0,
    *,
    is_tuned: bool = True,
) -> list[EvaluationTrial]:
    """Every policy with every method, and with the trivial ones, in every scenario; what is named twice counts once.

    Args:
        scenarios: to drive.
        policies: names or model files.
        methods: names.
        futures: by which the need of every spell is told; 0 leaves it untold.
        is_tuned: whether a method takes the model and the settings that were made for the policy, see ``fitting``.

    Raises:
        InputError: there is no such policy, model file or method, or a model cannot be read.
    """
    trials = []
    for policy, method in product(dict.fromkeys(policies), dict.fromkeys([*TRIVIAL, *methods])):
        parameters = fitting(method, policy) if is_tuned and method not in TRIVIAL else {}
        key = driver_key(policy, method, parameters)
        trials += [EvaluationTrial(scenario, policy, method, key, futures, parameters) for scenario in scenarios]
    return trials


def run_trials(
    trials: Sequence[EvaluationTrial], journal: Journal, workers: int, told: Callable[[int], None] = lambda _done: None
) -> list[Driven]:
    """Drive what the journal does not hold yet; what comes out does not depend on the number of workers.

    Args:
        trials: to drive.
        journal: of finished ones.
        workers: processes.
        told: hears how many are done.

    Raises:
        InputError: the journal cannot be written.
        SimulationError: a worker process died.
    """
    keys = [trial.key for trial in trials]
    known = {key: kept for key in keys if (kept := journal.get(key)) is not None}
    missing = [*{key: trial for key, trial in zip(keys, trials, strict=True) if key not in known}.values()]
    found = {key: EpisodeResult.parse(kept) for key, kept in known.items()}
    faults: dict[str, str] = {}
    told(len(trials) - len(missing))
    with fan_out(workers, len(missing)) as mapper:
        for number, driven in enumerate(mapper(drive_trial, missing), len(trials) - len(missing) + 1):
            if driven.result is None:
                faults[driven.trial.key] = driven.fault
            else:
                journal.add(driven.trial.key, driven.result.dump())
                found[driven.trial.key] = driven.result
            told(number)
    return [Driven(trial, found.get(key), faults.get(key, "")) for key, trial in zip(keys, trials, strict=True)]


def drive_trial(trial: EvaluationTrial) -> Driven:
    """Drive one episode in this process; whatever goes wrong is a result here."""
    repairer = partial(make_repairer, trial.method, trial.parameters, seed_of(trial.scenario.name))
    return drive_with(trial, partial(make_policy, trial.policy), repairer)


def drive_with(
    trial: EvaluationTrial, make_driver: Callable[[], Policy], make_guarded: Callable[[], GuardedRepairer]
) -> Driven:
    """As ``drive_trial``, with a policy and a repair method that are made otherwise than by their names.

    Args:
        trial: to drive.
        make_driver: makes the policy.
        make_guarded: makes the method behind its guard.
    """
    scenario = trial.scenario
    try:
        policy, repairer = make_driver(), Answering(make_guarded())
        if trial.futures:
            result = run_with_need(scenario, policy, repairer, trial.futures)
        else:
            result = run_episode(scenario, policy, repairer)
        if not result.is_finite:
            raise SimulationError("a pose or a command was not a number")  # noqa: TRY301
    except Exception as error:  # noqa: BLE001 - the others shall go on, and this one is reported
        text = " ".join(f"{type(error).__name__}: {error}".split())
        return Driven(trial, fault=f"{scenario.name}, policy {trial.policy}, {trial.told_as}: {text}")
    return Driven(trial, result)


def seed_of(name: str) -> int:
    """Seed for methods that draw numbers: the same for a scenario of this name in every run, another for every one."""
    return int.from_bytes(hashlib.sha256(f"roadmend/bench/{name}".encode()).digest()[:4], "big") >> 1
