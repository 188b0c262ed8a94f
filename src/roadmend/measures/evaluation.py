"""Evaluation: policies times repair methods times scenarios, and what each method makes of what the policy does alone."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import SimulationError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.core.outcome import EventKind
from roadmend.measures.case_result import CaseResult
from roadmend.measures.driver import driver_key
from roadmend.measures.intervals import wilson
from roadmend.measures.repair import summarise
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario

ALONE = "none"  # the method that never steps in: what the others are held against
TRIVIAL = (ALONE, "random")
_DASH = "\N{EN DASH}"
_HEAD = ("policy", "repair", "episodes", "goal [%]", "95 %", "collision [%]", "%Fix", "%Deg", "ΔE", "95 %", "dose [s]")


@dataclass(frozen=True, slots=True)
class Trial:
    """One episode to be driven; travels to other processes by pickle."""

    scenario: Scenario
    policy: str  # name or model file
    method: str
    driver: Key  # see ``measures.driver``

    @property
    def key(self) -> Key:
        """Of all that decides what comes out."""
        return entry_key([__name__], self.scenario.name, self.scenario.digest, self.driver)


@dataclass(frozen=True, slots=True)
class Driven:
    """What a trial came to, or why there is nothing."""

    trial: Trial
    result: EpisodeResult | None = None
    fault: str = ""


def trials_of(scenarios: Sequence[Scenario], policies: Sequence[str], methods: Sequence[str]) -> list[Trial]:
    """Every policy with every method, and with the trivial ones, in every scenario.

    Raises:
        InputError: there is no such policy, model file or method, or a model cannot be read.
    """
    chosen = tuple(dict.fromkeys([*TRIVIAL, *methods]))
    pairs = [(policy, method, driver_key(policy, method)) for policy in policies for method in chosen]
    return [Trial(scenario, *pair) for pair in pairs for scenario in scenarios]


def run_trials(
    trials: Sequence[Trial], journal: Journal, workers: int, told: Callable[[int], None] = lambda _done: None
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
    known = {trial.key: kept for trial in trials if (kept := journal.get(trial.key)) is not None}
    missing = [trial for trial in trials if trial.key not in known]
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
    return [Driven(trial, found.get(trial.key), faults.get(trial.key, "")) for trial in trials]


def drive_trial(trial: Trial) -> Driven:
    """Drive one episode in this process; whatever goes wrong is a result here."""
    scenario = trial.scenario
    try:
        repairer = make_repairer(trial.method, seed=_seed_of(scenario))
        result = run_episode(scenario, make_policy(trial.policy), repairer)
        if not result.is_finite:
            raise SimulationError("a pose or a command was not a number")  # noqa: TRY301
    except Exception as error:  # noqa: BLE001 - the others shall go on, and this one is reported
        text = " ".join(f"{type(error).__name__}: {error}".split())
        return Driven(trial, fault=f"{scenario.name}, policy {trial.policy}, {trial.method}: {text}")
    return Driven(trial, result)


def _seed_of(scenario: Scenario) -> int:
    """Seed for methods that draw numbers: the same for a scenario in every run, another for every scenario."""
    return int.from_bytes(hashlib.sha256(f"roadmend/evaluate/{scenario.name}".encode()).digest()[:4], "big") >> 1


def evaluate(driven: Sequence[Driven]) -> dict[str, dict[str, dict[str, Any]]]:
    """The figures of every method, by policy and method, as plain values.

    A scenario in which the policy alone collides is a violation, one in which it reaches its goal a success: of these
    are the figures of ``measures.repair.summarise``, and ``goal`` and ``collision`` [%] of all scenarios.
    """
    results: dict[str, dict[str, list[EpisodeResult]]] = {}
    for each in driven:
        if each.result is not None:
            results.setdefault(each.trial.policy, {}).setdefault(each.trial.method, []).append(each.result)
    return {
        policy: {method: _figures(found, methods[ALONE]) for method, found in methods.items()}
        for policy, methods in results.items()
        if ALONE in methods
    }


def _figures(results: Sequence[EpisodeResult], alone: Sequence[EpisodeResult]) -> dict[str, Any]:
    violations = {before.scenario: before.collided for before in alone if before.collided or before.reached_goal}
    decided = [
        CaseResult(result.scenario, "", violations[result.scenario], result)
        for result in results
        if result.scenario in violations
    ]
    goals, count = sum(result.reached_goal for result in results), len(results)
    outcomes = {kind.name: sum(result.outcome is kind for result in results) for kind in EventKind}
    return {
        "episodes": count,
        "outcomes": {name: number for name, number in outcomes.items() if number},
        "goal": {"share": 100.0 * goals / count, "interval": [100.0 * bound for bound in wilson(goals, count)]},
        "collision": 100.0 * sum(result.collided for result in results) / count,
        "repair": summarise(decided),
    }


def evaluation_rows(figures: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> list[list[str]]:
    """The figures as a table, the heading first."""
    rows = [[*_HEAD]]
    for policy, methods in figures.items():
        for method, each in methods.items():
            repair, goal = each["repair"], each["goal"]
            rows.append(
                [
                    policy,
                    method,
                    str(each["episodes"]),
                    _number(goal["share"]),
                    _span(goal["interval"]),
                    _number(each["collision"]),
                    _number(repair["fix"]),
                    _number(repair["deg"]),
                    _number(repair["delta_e"]),
                    _span(repair["intervals"]["delta_e"]),
                    _number(repair["dose"], 2),
                ]
            )
    return rows


def _number(value: float | None, digits: int = 1) -> str:
    return _DASH if value is None else f"{value:.{digits}f}"


def _span(interval: Sequence[float] | None) -> str:
    return _DASH if interval is None else f"{interval[0]:.1f} .. {interval[1]:.1f}"
