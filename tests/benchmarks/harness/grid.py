"""Many settings of repair methods over sets of scenarios: every one is driven once, and kept."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.progress import Progress

from harness.contenders import Contender
from roadmend.core.errors import RoadmendError
from roadmend.core.journal import Journal
from roadmend.measures.driver import driver_key
from roadmend.measures.evaluation import ALONE, Driven, EvaluationTrial, run_trials
from roadmend.measures.evaluation_figures import evaluate
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario

Figures = dict[str, dict[str, dict[str, Any]]]

FORMAT = "roadmend-grid-work/1"
TABLE_SEED, CHOICE_SEED = 60_000_000, 61_000_000  # of random drives: what is shown, and what settings are chosen on


@dataclass(frozen=True, slots=True)
class Setting:
    """A repair method with parameters under a policy."""

    title: str
    policy: str
    method: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    contender: Mapping[str, Any] = field(default_factory=dict)  # as it describes itself; empty where there is none

    @classmethod
    def of(cls, contender: Contender) -> "Setting":
        """That of somebody who takes part in the benchmark."""
        described = contender.describe()
        return cls(contender.name, contender.policy, contender.method, contender.parameters, described)

    def trials(self, scenarios: Sequence[Scenario], futures: int = 0) -> list[EvaluationTrial]:
        """One a scenario.

        Raises:
            InputError: there is no such policy, method or model, or a parameter is unusable.
        """
        key = driver_key(self.policy, self.method, self.parameters)
        return [
            EvaluationTrial(scenario, self.policy, self.method, key, futures, self.parameters, self.title)
            for scenario in scenarios
        ]


def random_drives(count: int, first: int) -> list[Scenario]:
    """So many scenarios of each family, drawn at random: ordinary driving, as far as the families go."""
    return [sample_scenario(family, first + number) for family in FAMILIES for number in range(count)]


def drive_all(trials: Sequence[EvaluationTrial], work: Path, workers: int, progress: Progress, what: str) -> Figures:
    """Figures by policy and setting (``measures.registry``), as ``drive_trials`` has them.

    Raises:
        InputError: the folder cannot be written.
        RoadmendError: an episode could not be driven.
        SimulationError: a worker process died.
    """
    return evaluate(drive_trials(trials, work, workers, progress, what))


def drive_trials(
    trials: Sequence[EvaluationTrial], work: Path, workers: int, progress: Progress, what: str
) -> list[Driven]:
    """Every trial's result; "none" must be among the settings of every policy if figures are to be made of them.

    Args:
        trials: to drive, those that the folder holds excepted.
        work: folder of finished ones.
        workers: processes.
        progress: where a task tells how far it is.
        what: it is called.

    Raises:
        InputError: the folder cannot be written.
        RoadmendError: an episode could not be driven.
        SimulationError: a worker process died.
    """
    task = progress.add_task(what, total=len(trials))
    with Journal(work / "results.jsonl", FORMAT, owns_folder=True) as journal:
        driven = run_trials(trials, journal, workers, lambda done: progress.update(task, completed=done))
    faults = [each.fault for each in driven if each.fault]
    if faults:
        raise RoadmendError(f"{len(faults)} episodes could not be driven; the first: {faults[0]}")
    return driven


def alone(policy: str) -> Setting:
    """The policy without repair."""
    return Setting(ALONE, policy, ALONE)
