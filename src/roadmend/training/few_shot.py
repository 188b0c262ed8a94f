"""Few-shot repair: a neural policy is fine-tuned on a few scenarios, without losing what it could do before.

In every scenario the privileged expert drives, and the policy drives while the expert says what it would do (DAgger,
Ross et al. 2011). The expert fails in most of what searches find, so ADReFT may repair its advice. What comes of it is
mixed with scenes of ordinary episodes, and after every epoch the policy drives a hard part of a validation set. The
epochs that are better there than the policy was drive ordinary scenarios, the best first, and the first that loses
nothing on these is kept. Where none does, weights part of the way between the old and the new ones are
tried; where these do not either, the policy stays as it was.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper, fan_out
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.measured_run import measured_run
from roadmend.networks.checkpoint import Checkpoint, Tensors, load_checkpoint, save_checkpoint
from roadmend.policies.neural import NeuralPolicy, load_model
from roadmend.repair.adreft.model import KIND
from roadmend.repair.registry import make_repairer
from roadmend.training.demonstrations import Lesson, gather, ordinary_lesson
from roadmend.training.few_shot_settings import FewShotSettings, ordinary_seeds, repair_model
from roadmend.training.imitation import NeuralNetwork, batches, learn, load_network
from roadmend.training.samples import Samples, samples_digest
from roadmend.training.torch_state import tensors_of
from roadmend.training.tuning_guard import TunedCandidate, TuningGuard, TuningTrial, mixture
from roadmend.world.families import sample_scenario
from roadmend.world.scenario import Scenario

Report = Callable[[str, int, int], None]  # what is being done, how much of it is done, how much there is
Gather = Callable[[Sequence[Lesson]], Iterator[Samples]]
Drive = Callable[[Path, Sequence[Scenario]], Iterator[DrivingMeasures]]
Epochs = Iterator[tuple[NeuralNetwork, float]]  # the network after every epoch, and the loss of the action in it


@dataclass(frozen=True, slots=True)
class TuningOrigin:
    """What a repair follows from beside its scenarios; goes into the model's header."""

    selection: str = ""  # digest of the file that the scenarios come from
    bank: str = ""  # digest of the bank
    command: str = ""


@dataclass(frozen=True)
class FewShotRepair:
    """What came of a repair."""

    path: Path
    digest: str  # of the model file
    kept: TuningTrial
    trials: tuple[TuningTrial, ...]
    scenes: int  # demonstrated
    outcomes: tuple[str, ...] = field(default=())  # of the demonstrations' episodes


@dataclass(frozen=True)
class Labour:
    """Who does the work of a repair, and who hears of it."""

    workers: int = 1  # processes
    report: Report = lambda _what, _done, _total: None  # hears what is being done
    gathering: Gather | None = None  # drives lessons instead of processes of its own, for instance from a store
    driving: Drive | None = None  # drives the validation set, likewise


def few_shot_repair(
    model: Path,
    scenarios: Sequence[Scenario],
    settings: FewShotSettings,
    seed: int,
    out: Path,
    *,
    validation: Sequence[Scenario] = (),
    origin: TuningOrigin | None = None,
    labour: Labour | None = None,
) -> FewShotRepair:
    """Fine-tune a neural policy on scenarios; the same arguments give the same model file.

    Args:
        model: the policy's model file.
        scenarios: to learn from, at least one.
        settings: how.
        seed: of the order of the scenes.
        out: model file to write; its header names the parent, the selection, the bank, the settings and the seed.
        validation: what the kept epoch is chosen by, beside ordinary scenarios; the scenarios themselves if none.
        origin: goes into the header.
        labour: who does it, and who hears of it.

    Raises:
        InputError: there is no scenario, the model is no neural policy's, or ``out`` cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    if not scenarios:
        raise InputError("scenarios", "there is none to learn from", "select at least one")
    parent, labour = load_model(model), labour or Labour()
    with fan_out(labour.workers) as mapper:
        gather, drive = labour.gathering or _gathering(mapper), labour.driving or _driving(mapper)
        work = _TuningWork(model, parent, settings, seed, gather, drive, labour.report)
        return work.repair(scenarios, validation or scenarios, out, origin or TuningOrigin())


def lessons_of(scenario: Scenario, model: Path, settings: FewShotSettings) -> list[Lesson]:
    """The episodes in which a scenario is demonstrated; the same for every seed, so that they can be kept."""
    repair = repair_model(settings)
    return [
        Lesson(
            scenario,
            f"{scenario.digest}/{number}",
            driver,
            settings.expert_share,
            settings.noise,
            settings.every,
            repair,
        )
        for driver, count in ((None, settings.expert_drives), (model, settings.policy_drives))
        for number in range(count)
    ]


def replay_lessons(model: Path, settings: FewShotSettings) -> list[Lesson]:
    """The ordinary episodes that old skill is kept with.

    Unless ``replay_repair`` says otherwise, the expert alone advises in them, as it did when the policy was first taught.
    """
    repair = repair_model(settings) if settings.replay_repair else None
    return [
        ordinary_lesson(family, seed, model, settings.expert_share, settings.noise, settings.every, repair)
        for family, seed in ordinary_seeds(settings.replay_seed, settings.replay)
    ]


@dataclass
class _TuningWork:
    model: Path
    parent: Checkpoint
    settings: FewShotSettings
    seed: int
    gathering: Gather
    driving: Drive
    report: Report

    def repair(
        self, scenarios: Sequence[Scenario], hard: Sequence[Scenario], out: Path, origin: TuningOrigin
    ) -> FewShotRepair:
        settings = self.settings
        lessons = [lesson for one in scenarios for lesson in lessons_of(one, self.model, settings)]
        shown = self._gathered("demonstrations", lessons)
        replay = replay_lessons(self.model, settings)
        old = self._gathered("replay", replay) if replay else None
        header = self._header(origin, shown, scenarios)
        epochs = self._epochs(shown, old)
        if settings.keep == "last":
            trials, tensors = _run_through(epochs)
            kept = trials[-1]
        else:
            ordinary = ordinary_seeds(settings.validation_seed, settings.validation)
            guard = TuningGuard([sample_scenario(family, seed) for family, seed in ordinary], hard, settings.tolerance)
            trials, tensors, kept = self._guarded(
                epochs, guard, out.with_name(f".{out.stem}.epoch{out.suffix}"), header
            )
        header["metrics"] |= {"trials": [asdict(trial) for trial in trials], "kept": asdict(kept)}
        digest = save_checkpoint(out, tensors, header)
        return FewShotRepair(out, digest, kept, tuple(trials), len(shown), shown.outcomes)

    def _guarded(
        self, epochs: Epochs, guard: TuningGuard, beside: Path, header: dict[str, Any]
    ) -> tuple[list[TuningTrial], Tensors, TuningTrial]:
        """All trials, and the weights of the one that is kept; every model that is tried is driven from ``beside``."""
        old = dict(self.parent.tensors)

        def tried(epochs: int, tensors: Tensors, loss: float | None, share: float = 1.0) -> TunedCandidate:
            save_checkpoint(beside, tensors, header)
            return TunedCandidate(guard.trial(epochs, self._driven(beside, guard.hard), loss, share), tensors)

        def judged(candidate: TunedCandidate) -> TunedCandidate:
            save_checkpoint(beside, candidate.tensors, header)
            return guard.judged(candidate, self._driven(beside, guard.ordinary))

        try:
            first = guard.first(self._driven(self.model, guard.hard), self._driven(self.model, guard.ordinary))
            kept = TunedCandidate(first, old)
            found = [tried(number, tensors_of(network), loss) for number, (network, loss) in enumerate(epochs, 1)]
            better = guard.ranked(found)
            for candidate in better:
                judgement = judged(candidate)
                found[candidate.trial.epochs - 1] = judgement
                if guard.allows(judgement.trial):
                    kept = judgement
                    break
            mixing = [] if kept.trial.epochs else [(best, one) for best in better[:1] for one in self.settings.mixtures]
            for best, share in mixing:
                mixed = mixture(old, best.tensors, share)
                candidate = tried(best.trial.epochs, mixed, best.trial.action_loss, share)
                found.append(judged(candidate) if guard.ranked([candidate]) else candidate)
                if guard.allows(found[-1].trial):
                    kept = found[-1]
                    break
        finally:
            beside.unlink(missing_ok=True)
        return [first, *(candidate.trial for candidate in found)], kept.tensors, kept.trial

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

    def _epochs(self, shown: Samples, old: Samples | None) -> Epochs:
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

    def _header(self, origin: TuningOrigin, shown: Samples, scenarios: Sequence[Scenario]) -> dict[str, Any]:
        before, repair = self.parent.header, repair_model(self.settings)
        return {
            "kind": before["kind"],
            "configuration": {
                **before["configuration"],
                "few_shot": {
                    "settings": self.settings.model_dump(mode="json"),
                    "seed": self.seed,
                    "scenarios": [scenario.digest for scenario in scenarios],
                    **asdict(origin),
                    "repair": "" if repair is None else load_checkpoint(repair, KIND).digest,
                },
            },
            "data_digest": samples_digest(shown),
            "metrics": {"scenes": len(shown)},
            "ancestry": [self.parent.digest, *before["ancestry"]],
        }


def _run_through(epochs: Epochs) -> tuple[list[TuningTrial], Tensors]:
    trials, tensors = list[TuningTrial](), dict[str, NDArray[np.float32]]()
    for number, (network, loss) in enumerate(epochs, 1):
        trials, tensors = [*trials, TuningTrial(number, None, None, loss)], tensors_of(network)
    return trials, tensors


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
        return mapper(drive_once, [(model, scenario) for scenario in scenarios])

    return drive


def drive_once(task: tuple[Path, Scenario]) -> DrivingMeasures:
    """The measures of the policy with a model in a scenario, without repair."""
    model, scenario = task
    return measured_run(scenario, NeuralPolicy(model), make_repairer("none"))[1]
