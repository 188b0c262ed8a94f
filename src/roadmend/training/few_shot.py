"""Few-shot repair: a neural policy is fine-tuned on a few scenarios, without losing what it could do before.

In every scenario the privileged expert drives, and the policy drives while the expert says what it would do (DAgger,
Ross et al. 2011). What comes of it is mixed with scenes of ordinary episodes, and after every epoch the policy drives a
validation set: the epoch is kept that scores best there without losing on the ordinary scenarios that went well before.
Where no epoch does, the policy stays as it was.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.evaluation.driving_measures import DrivingMeasures
from roadmend.evaluation.measured_run import measured_run
from roadmend.learning.checkpoint import Checkpoint, save_checkpoint
from roadmend.policies.neural import NeuralPolicy, load_model
from roadmend.training.few_shot_settings import FewShotSettings, ordinary_seeds
from roadmend.training.imitation import NeuralNetwork, batches, learn, load_network, tensors_of
from roadmend.training.imitation_rollout import Lesson, gather, ordinary_lesson
from roadmend.training.samples import Samples, samples_digest
from roadmend.training.workers import Mapper, open_mapper
from roadmend.world.families import sample_scenario
from roadmend.world.scenario import Scenario

Report = Callable[[str, int, int], None]  # what is being done, how much of it is done, how much there is
Gather = Callable[[Sequence[Lesson]], Iterator[Samples]]
Drive = Callable[[Path, Sequence[Scenario]], Iterator[DrivingMeasures]]


@dataclass(frozen=True, slots=True)
class Origin:
    """What a repair follows from beside its scenarios; goes into the model's header."""

    selection: str = ""  # digest of the file that the scenarios come from
    bank: str = ""  # digest of the bank
    command: str = ""


@dataclass(frozen=True, slots=True)
class Trial:
    """The policy after some epochs on the validation set."""

    epochs: int  # 0: as it was
    driving_score: float  # mean over the validation set
    ordinary: float  # mean over its ordinary scenarios that went well before
    action_loss: float | None = None  # of the last epoch's training


@dataclass(frozen=True)
class Repair:
    """What came of a repair."""

    path: Path
    digest: str  # of the model file
    kept: Trial
    trials: tuple[Trial, ...]
    scenes: int  # demonstrated
    outcomes: tuple[str, ...] = field(default=())  # of the demonstrations' episodes


def few_shot_repair(
    model: Path, scenarios: Sequence[Scenario], settings: FewShotSettings, seed: int, out: Path, *,
    validation: Sequence[Scenario] = (), origin: Origin | None = None, workers: int = 1,
    report: Report = lambda _what, _done, _total: None, gathering: Gather | None = None, driving: Drive | None = None,
) -> Repair:  # fmt: skip
    """Fine-tune a neural policy on scenarios; the same arguments give the same model file.

    Args:
        model: the policy's model file.
        scenarios: to learn from, at least one.
        settings: how.
        seed: of the order of the scenes.
        out: model file to write; its header names the parent, the selection, the bank, the settings and the seed.
        validation: what the kept epoch is chosen by, beside ordinary scenarios; the scenarios themselves if none.
        origin: goes into the header.
        workers: processes.
        report: hears what is being done.
        gathering: drives lessons instead of this function's own processes, for instance from a store.
        driving: drives the validation set, likewise.

    Raises:
        InputError: there is no scenario, the model is no neural policy's, or ``out`` cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    if not scenarios:
        raise InputError("scenarios", "there is none to learn from", "select at least one")
    parent = load_model(model)
    with open_mapper(workers) as mapper:
        work = _Work(
            model, parent, settings, seed, gathering or _gathering(mapper), driving or _driving(mapper), report
        )  # fmt: skip
        return work.repair(scenarios, validation or scenarios, out, origin or Origin())


def lessons_of(scenario: Scenario, model: Path, settings: FewShotSettings) -> list[Lesson]:
    """The episodes in which a scenario is demonstrated; the same for every seed, so that they can be kept."""
    return [
        Lesson(
            scenario, f"{scenario.digest}/{number}", driver, settings.expert_share, settings.noise, settings.every
        )
        for driver, count in ((None, settings.expert_drives), (model, settings.policy_drives))
        for number in range(count)
    ]  # fmt: skip


@dataclass
class _Work:
    model: Path
    parent: Checkpoint
    settings: FewShotSettings
    seed: int
    gathering: Gather
    driving: Drive
    report: Report

    def repair(self, scenarios: Sequence[Scenario], hard: Sequence[Scenario], out: Path, origin: Origin) -> Repair:
        settings = self.settings
        lessons = [lesson for one in scenarios for lesson in lessons_of(one, self.model, settings)]
        shown = self._gathered("demonstrations", lessons)
        replay = [
            ordinary_lesson(family, seed, self.model, settings.expert_share, settings.noise, settings.every)
            for family, seed in ordinary_seeds(settings.replay_seed, settings.replay)
        ]  # fmt: skip
        old = self._gathered("replay", replay) if replay else None
        ordinary = [
            sample_scenario(family, seed) for family, seed in ordinary_seeds(settings.validation_seed, settings.validation)
        ]  # fmt: skip
        guard = _Guard(ordinary, hard, settings.tolerance)
        trials, best, tensors = [guard.first(self._driven(self.model, guard.scenarios))], 0, self.parent.tensors
        beside = out.with_name(f".{out.stem}.epoch{out.suffix}")
        try:
            for number, (network, loss) in enumerate(self._epochs(shown, old), 1):
                save_checkpoint(beside, tensors_of(network), self._header(origin, shown, scenarios, trials))
                trials.append(guard.trial(number, self._driven(beside, guard.scenarios), loss))
                if guard.passes(trials[-1]) and trials[-1].driving_score > trials[best].driving_score:
                    best, tensors = number, {name: array.copy() for name, array in tensors_of(network).items()}
        finally:
            beside.unlink(missing_ok=True)
        header = self._header(origin, shown, scenarios, trials)
        header["metrics"]["kept"] = asdict(trials[best])
        digest = save_checkpoint(out, tensors, header)
        return Repair(out, digest, trials[best], tuple(trials), len(shown), shown.outcomes)

    def _gathered(self, what: str, lessons: Sequence[Lesson]) -> Samples:
        parts = []
        for part in self.gathering(lessons):
            parts.append(part)
            self.report(what, len(parts), len(lessons))
        return Samples.join(parts)

    def _driven(self, model: Path, scenarios: Sequence[Scenario]) -> list[DrivingMeasures]:
        found = []
        for measures in self.driving(model, scenarios):
            found.append(measures)
            self.report("validation", len(found), len(scenarios))
        return found

    def _epochs(self, shown: Samples, old: Samples | None) -> Iterator[tuple[NeuralNetwork, float]]:
        """The network after every epoch, and the loss of the action in it."""
        settings = self.settings
        torch.manual_seed(self.seed)
        generator = np.random.default_rng(self.seed)
        network = load_network(self.parent, self.model)
        samples = shown if old is None else Samples.join([shown, old])
        share = settings.replay_share if old is not None else 0.0
        replayed = round(len(shown) * share / (1.0 - share))
        optimizer = torch.optim.AdamW(
            network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
        )
        steps = settings.epochs * -(-(len(shown) + replayed) // settings.batch)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps, 0.02 * settings.learning_rate)
        change_weight = float(self.parent.header["configuration"]["training"]["change_weight"])
        for number in range(settings.epochs):
            rows = _rows(len(shown), len(samples), replayed, generator)
            chosen = batches(samples, rows, settings.batch, generator, torch.device("cpu"))
            learned = learn(network, optimizer, schedule, chosen, change_weight)
            self.report("learning", number + 1, settings.epochs)
            yield network, learned.action

    def _header(
        self, origin: Origin, shown: Samples, scenarios: Sequence[Scenario], trials: Sequence[Trial]
    ) -> dict[str, Any]:
        before = self.parent.header
        return {
            "kind": before["kind"],
            "configuration": {
                **before["configuration"],
                "few_shot": {
                    "settings": self.settings.model_dump(mode="json"), "seed": self.seed,
                    "scenarios": [scenario.digest for scenario in scenarios], **asdict(origin),
                },
            },
            "data_digest": samples_digest(shown),
            "metrics": {"scenes": len(shown), "trials": [asdict(trial) for trial in trials]},
            "ancestry": [self.parent.digest, *before["ancestry"]],
        }  # fmt: skip


@dataclass
class _Guard:
    """What is asked of an epoch, and what it came to."""

    ordinary: Sequence[Scenario]
    hard: Sequence[Scenario]
    tolerance: float
    before: float = 0.0
    _fine: list[int] = field(default_factory=list)  # ordinary scenarios that went well before

    @property
    def scenarios(self) -> list[Scenario]:
        return [*self.ordinary, *self.hard]

    def first(self, measures: Sequence[DrivingMeasures]) -> Trial:
        """What the policy comes to as it is."""
        self._fine = [place for place in range(len(self.ordinary)) if measures[place].success]
        trial = self.trial(0, measures, None)
        self.before = trial.ordinary
        return trial

    def trial(self, epochs: int, measures: Sequence[DrivingMeasures], loss: float | None) -> Trial:
        ordinary = [measures[place].driving_score for place in self._fine]
        whole = fmean(each.driving_score for each in measures)
        return Trial(epochs, whole, fmean(ordinary) if ordinary else 0.0, loss)

    def passes(self, trial: Trial) -> bool:
        return trial.ordinary >= self.before - self.tolerance


def _rows(shown: int, total: int, replayed: int, generator: np.random.Generator) -> NDArray[np.int64]:
    """All that was demonstrated, and as much of the old as is wanted: each once before any twice."""
    count = total - shown
    if not count or not replayed:
        return np.arange(shown)
    turns = [generator.permutation(count) for _ in range(-(-replayed // count))]
    return np.concatenate([np.arange(shown), shown + np.concatenate(turns)[:replayed]])


def _gathering(mapper: Mapper) -> Gather:
    return lambda lessons: mapper(gather, lessons)


def _driving(mapper: Mapper) -> Drive:
    def drive(model: Path, scenarios: Sequence[Scenario]) -> Iterator[DrivingMeasures]:
        return mapper(_measure, [(model, scenario) for scenario in scenarios])

    return drive


def _measure(task: tuple[Path, Scenario]) -> DrivingMeasures:
    model, scenario = task
    return measured_run(scenario, NeuralPolicy(model))
