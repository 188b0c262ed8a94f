"""ADReFT from a corpus to a model file: frames, supervised stage, threshold, ReFT, and a look at validation."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.measures.case_result import CaseResult
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.training.adreft.calibration import MonitorQuality, calibrate, monitor_quality
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.adreft.configuration import TrainingConfiguration
from roadmend.training.adreft.consistency import check_configuration
from roadmend.training.adreft.counterfactual import Counterfactuals
from roadmend.training.adreft.counterfactual_stage import CounterfactualStage
from roadmend.training.adreft.frames import FrameSet
from roadmend.training.adreft.futures_practice import FuturesPractice
from roadmend.training.adreft.gathering import Recipe, gather_frames
from roadmend.training.adreft.labels import make_scheme
from roadmend.training.adreft.learning_stage import LearningStage, PracticeFigures
from roadmend.training.adreft.network import digest_of_cases, load_start, save_model
from roadmend.training.adreft.practice import PracticeStage
from roadmend.training.adreft.random_case import random_cases
from roadmend.training.adreft.reinforcement import ReinforcementStage, RoundFigures
from roadmend.training.adreft.rollouts_stage import TuningFigures
from roadmend.training.adreft.rollouts_tuning import RolloutsTuning
from roadmend.training.adreft.scoring import monitor_scores
from roadmend.training.adreft.stage import PRACTICE_STATE, Report, StageRun, Tensors, TrainingSubject
from roadmend.training.adreft.supervised import EpochFigures, SupervisedStage
from roadmend.training.adreft.trial_plan import TrialPlan
from roadmend.training.adreft.trial_set import TrialSet
from roadmend.training.adreft.trials import CaseTrials, gather_trials
from roadmend.training.closed_loop import EpisodeCase, Summary, evaluate_cases, summarise

SUPERVISED_STATE = "supervised.safetensors"
GUIDE = "guide-{}.safetensors"  # the model that drives along in a round
REINFORCEMENT_STATE = "reinforcement.safetensors"

Only = Literal["supervised", "reinforcement"] | None


@dataclass(frozen=True, slots=True)
class Trained:
    """What came of it, on the validation split."""

    digest: str  # of the model file
    threshold: float
    monitor: MonitorQuality
    summary: Summary
    results: list[CaseResult]


@dataclass(frozen=True, slots=True)
class _Supervised:
    """The networks before ReFT."""

    model: ModelConfiguration
    tensors: Tensors
    figures: EpochFigures | None
    data_digest: str
    ancestry: list[str]


class Pipeline:
    """One training. All that takes long is kept in ``work``, so that the same call goes on where it was interrupted."""

    def __init__(
        self,
        configuration: TrainingConfiguration,
        subject: TrainingSubject,
        *,
        seed: int,
        device: str,
        mapper: Mapper,
        work: Path,
        report: Report = lambda _what, _done, _total, _how: None,
    ) -> None:
        """Prepare a training.

        Args:
            configuration: every hyper-parameter.
            subject: policy and cases.
            seed: of all chance.
            device: torch's name of where to compute.
            mapper: runs episodes side by side.
            work: folder for frames, states and TensorBoard's logs.
            report: called as things go on.

        Raises:
            InputError: a split is empty, or the configuration names what there is not.
        """
        for name, cases in (("training", subject.driver.training), ("validation", subject.validation)):
            if not any(case.is_violation for case in cases):
                raise InputError(f"{name} split", "holds no violation", "give a corpus that has some")
        check_configuration(configuration)
        self._configuration, self._subject = configuration, subject
        self._seed, self._device, self._mapper, self._work, self._report = seed, device, mapper, work, report
        self._model = configuration.model.configuration()
        self._scheme = make_scheme(configuration.frames.labels)
        self._futures: FuturesPractice | None = None
        if configuration.practice.epochs and configuration.practice.method == "futures":
            self._futures = FuturesPractice(
                configuration, subject, seed=seed, device=device, mapper=mapper, work=work, report=report
            )

    def run(self, out: Path, only: Only = None, start: Path | None = None) -> Trained:
        """Train and write the model.

        Args:
            out: the model file.
            only: one of the stages; "reinforcement" takes the networks of ``start``, or of an earlier call's stage.
            start: a model of ADReFT to begin with instead of the supervised stage.

        Raises:
            InputError: a case, a file or a setting is unusable.
            SimulationError: SUMO failed, or a worker process died.
        """
        if start is None and only == "reinforcement":
            self._check_supervised()
        begun = None if start is None else self._from_model(start)  # before anything is driven: it may be unusable
        validation = self._frames(self._subject.validation, "validation")
        before = begun or self._prepare(validation)
        threshold, quality = self._calibrate(before, validation)
        tensors = before.tensors
        history: list[RoundFigures] = []
        if only != "supervised" and self._configuration.reinforcement.episodes:
            tensors, history = self._reinforce(before, threshold)
        tuned: list[TuningFigures] = []
        if only != "supervised" and self._configuration.rollouts.rounds:
            tensors, threshold, tuned = self._roll_out(tensors)
            quality = monitor_quality(*self._judged(before.model, tensors, validation), threshold)
        header = self._header(before, quality, history, only)
        header["metrics"]["rollouts"] = [asdict(figures) for figures in tuned]
        if self._futures is not None:
            header["metrics"]["futures"] = self._futures.judge(tensors, threshold)
        beside = self._work / "finished.safetensors"
        save_model(beside, before.model, tensors, threshold, **header)
        results = self._look(beside)
        summary = summarise(results)
        header["metrics"] = {**header["metrics"], "validation": summary.as_dict()}
        digest = save_model(out, before.model, tensors, threshold, **header)
        beside.unlink()
        return Trained(digest, threshold, quality, summary, results)

    def _frames(self, cases: Sequence[EpisodeCase], name: str) -> FrameSet:
        section = self._configuration.frames
        stride = section.stride if name == "training" else section.validation_stride
        subject = self._subject
        recipe = Recipe(subject.driver.policy, self._model.tokenizer, stride)
        gathered: list[CaseFrames] = []

        def report(frames: CaseFrames) -> None:
            gathered.append(frames)
            self._report(f"{name} frames", len(gathered), len(cases), f"{sum(map(len, gathered))} frames")

        gather_frames(cases, recipe, self._work / "frames", self._mapper, report)
        self._report(f"{name} labels", 0, len(cases), self._configuration.frames.labels)
        self._scheme.prepare(cases, subject.driver.policy, self._work / "labels", self._mapper)
        labels = [self._scheme.label(case, frames) for case, frames in zip(cases, gathered, strict=True)]
        self._report(f"{name} labels", len(cases), len(cases), self._configuration.frames.labels)
        return FrameSet.join(gathered, labels, self._model.encoder.attributes)

    def _check_supervised(self) -> None:
        """Raise InputError unless an earlier call's stage is there to fine-tune."""
        practice = self._configuration.practice
        state = self._work / (PRACTICE_STATE.format(practice.rounds - 1) if practice.epochs else SUPERVISED_STATE)
        if not state.exists():
            mend = "train that stage first, or give a model with --start"
            raise InputError(str(state), "there is no supervised stage to begin with", mend)

    def _prepare(self, validation: FrameSet) -> _Supervised:
        """The networks before ReFT: by practice where there is some, else by the supervised stage."""
        return self._practise(validation) if self._configuration.practice.epochs else self._supervise(validation)

    def _practise(self, validation: FrameSet) -> _Supervised:
        """Rounds of trials or of moments, each learned from together with all before it."""
        if self._futures is not None:
            tensors, digest = self._futures.run()
            return _Supervised(self._model, tensors, None, digest, self._futures.ancestry)
        section = self._configuration.practice
        gathered: list[CaseTrials] = []
        result: _Supervised | None = None
        for number in range(section.rounds):
            gathered += self._try(number, result, validation)
            trials = TrialSet.join(gathered, section)
            own = section.of_round(number)
            labels = Counterfactuals.join(gathered, own) if own.method == "counterfactual" else None
            if number + 1 == section.rounds:
                gathered.clear()  # gigabytes, which the joined trials hold once more
            run = StageRun(
                self._seed + number,
                self._device,
                self._work / PRACTICE_STATE.format(number),
                self._work / "tensorboard" / f"practice-{number}",
            )
            start = None if result is None else result.tensors
            stage: LearningStage
            if labels is None:
                stage = PracticeStage(self._model, own, trials, run, start)
            else:
                stage = CounterfactualStage(self._model, own, trials, labels, run, start)

            def report(figures: PracticeFigures, size: int = len(trials), of: int = own.epochs) -> None:
                self._report("practice", figures.epoch, of, f"{size} decisions, loss {figures.value_loss:.4f}")

            result = _Supervised(self._model, stage.run(report), None, trials.digest, [])
        assert result is not None
        return result

    def _try(self, number: int, before: _Supervised | None, validation: FrameSet) -> list[CaseTrials]:
        """The trials of one round, with the model of the round before at the wheel."""
        section, subject = self._configuration.practice.of_round(number), self._subject
        guide, digest = None, ""
        if before is not None:
            guide = self._work / GUIDE.format(number)
            digest = save_model(guide, before.model, before.tensors, self._calibrate(before, validation)[0])
        plan = TrialPlan(
            section.per_violation,
            section.per_success,
            section.blinded,
            section.interval,
            self._seed,
            digest,
            section.gentle_per_violation,
            section.gentle_per_success,
        )
        drawn = replace(plan, blinded=section.random_blinded, gentle_per_violation=0, gentle_per_success=0)
        jobs = [
            (Recipe(driver.policy, self._model.tokenizer, 1), cases, how)
            for driver in (subject.driver, *subject.also)
            for cases, how in ((driver.training, plan), (random_cases(driver.policy, section.random_cases), drawn))
        ]
        done, episodes, total = 0, 0, sum(len(cases) for _, cases, _ in jobs)

        def count(trials: CaseTrials) -> None:
            nonlocal done, episodes
            done, episodes = done + 1, episodes + len(trials.lengths)
            self._report("trials", done, total, f"{episodes} episodes")

        gathered: list[CaseTrials] = []
        for recipe, cases, how in jobs:
            gathered += gather_trials(cases, recipe, how, self._work / "trials", self._mapper, count, guide)
        return gathered

    def _supervise(self, validation: FrameSet) -> _Supervised:
        section, state = self._configuration.supervised, self._work / SUPERVISED_STATE
        training = self._frames(self._subject.driver.training, "training")
        stage = SupervisedStage(
            self._model,
            section,
            training,
            validation,
            StageRun(self._seed, self._device, state, self._work / "tensorboard"),
        )

        def report(epoch: int, figures: EpochFigures | None) -> None:
            how = f"F1 {figures.f1:.3f}, loss {figures.loss:.4f}" if figures is not None else ""
            self._report("supervised stage", epoch, section.epochs, how)

        result = stage.run(report)
        return _Supervised(self._model, result.tensors, result.figures, training.digest, [])

    def _from_model(self, start: Path) -> _Supervised:
        checkpoint = load_start(start, self._model)
        header = checkpoint.header
        ancestry = [checkpoint.digest, *header["ancestry"]]
        return _Supervised(self._model, checkpoint.tensors, None, header["data_digest"], ancestry)

    def _calibrate(self, before: _Supervised, validation: FrameSet) -> tuple[float, MonitorQuality]:
        """lambda_safe, by harmless drives or by critical frames, and how good the monitor is at these."""
        scores, critical = self._judged(before.model, before.tensors, validation)
        if self._futures is not None:
            threshold = self._futures.calibrate(before.tensors)
        else:
            threshold = calibrate(scores, critical, self._configuration.supervised.recall)
        return threshold, monitor_quality(scores, critical, threshold)

    def _judged(
        self, model: ModelConfiguration, tensors: Tensors, validation: FrameSet
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """The monitor's scores of the frames that have a label, and whether each is critical."""
        scores = monitor_scores(model, tensors, validation, validation.action, self._mapper)
        judged = validation.critical_weight > 0.0
        return scores[judged], validation.critical[judged] > 0.5

    def _reinforce(self, before: _Supervised, threshold: float) -> tuple[Tensors, list[RoundFigures]]:
        section, subject = self._configuration.reinforcement, self._subject
        run = StageRun(self._seed, self._device, self._work / REINFORCEMENT_STATE, self._work / "tensorboard")
        stage = ReinforcementStage(before.model, before.tensors, threshold, section, subject, run, mapper=self._mapper)
        best = -math.inf

        def report(episodes: int, figures: RoundFigures) -> None:
            nonlocal best
            best = best if figures.worth is None else max(best, figures.worth)
            how = f"fixed {figures.fixed:.2f}" + (f", best {best:.1f}" if math.isfinite(best) else "")
            self._report("fine-tuning", episodes, section.episodes, how)

        tensors = stage.run(report)
        return tensors, stage.history

    def _roll_out(self, tensors: Tensors) -> tuple[Tensors, float, list[TuningFigures]]:
        """ReFT by rollouts: the networks, the threshold above which the monitor asks the adapter, and the rounds."""
        assert self._futures is not None
        section = self._configuration.rollouts
        threshold = self._futures.calibrate(tensors, section.touched)
        tuning = RolloutsTuning(
            self._model,
            section,
            self._subject,
            seed=self._seed,
            device=self._device,
            mapper=self._mapper,
            work=self._work,
            report=self._report,
        )
        tuned, history = tuning.run(tensors, threshold)
        return tuned, threshold, history

    def _look(self, model: Path) -> list[CaseResult]:
        subject = self._subject
        done = 0

        def report(_result: CaseResult) -> None:
            nonlocal done
            done += 1
            self._report("validation in closed loop", done, len(subject.validation), "")

        return evaluate_cases(
            subject.validation,
            subject.driver.policy,
            "adreft",
            {"model": str(model)},
            mapper=self._mapper,
            report=report,
        )

    def _header(
        self, before: _Supervised, quality: MonitorQuality, history: list[RoundFigures], only: Only
    ) -> dict[str, Any]:
        subject = self._subject
        worths = [figures.worth for figures in history if figures.worth is not None]
        return {
            "configuration": {
                "training": self._configuration.model_dump(mode="json"),
                "seed": self._seed,
                "device": self._device,  # the bits depend on it
                "only": only,
                "policy": subject.driver.policy,
                "roadmend": __version__,
            },
            "data_digest": before.data_digest,
            "data": {
                **subject.driver.as_header(),
                "validation": digest_of_cases(subject.validation),
                "also": [{"name": other.policy, **other.as_header()} for other in subject.also],
            },
            "ancestry": before.ancestry,
            "metrics": {
                "supervised": None if before.figures is None else asdict(before.figures),
                "monitor": asdict(quality),
                "reinforcement": {
                    "episodes": history[-1].episodes if history else 0,
                    "updates": history[-1].updates if history else 0,
                    "worth_before": history[0].worth if history and history[0].round == 0 else None,
                    "worth": max(worths, default=None),
                },
            },
        }


def open_work(work: Path, *, resume: bool | None, keep_supervised: bool) -> None:
    """Make the folder; states of an earlier training are gone on with or removed, as was asked for.

    Raises:
        InputError: there are such states and nothing was asked for, or the folder cannot be made.
    """
    states = [work / REINFORCEMENT_STATE]
    if not keep_supervised:
        states += [work / SUPERVISED_STATE, *sorted(work.glob(PRACTICE_STATE.format("*")))]
    found = [state for state in states if state.exists()]
    if found and resume is None:
        raise InputError(str(work), "holds a training already", "go on with --resume, or begin anew with --restart")
    try:
        for state in found if resume is False else ():
            state.unlink()
        work.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(str(work), f"cannot be written ({error.strerror})", "choose a writable folder") from None
