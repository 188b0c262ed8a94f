"""Rounds of practice on futures, the threshold that leaves harmless drives alone, and how reliable the monitor is."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.outcome import EventKind
from roadmend.networks.checkpoint import find_model
from roadmend.training.adreft.calibration import calibrate_untouched
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.adreft.case_moments import CaseMoments
from roadmend.training.adreft.configuration import TrainingConfiguration
from roadmend.training.adreft.futures_stage import FuturesStage
from roadmend.training.adreft.gathering import Recipe, gather_frames
from roadmend.training.adreft.learning_stage import PracticeFigures
from roadmend.training.adreft.moment_plan import MomentPlan
from roadmend.training.adreft.moment_set import MomentSet
from roadmend.training.adreft.moments import gather_moments
from roadmend.training.adreft.network import load_start, save_model
from roadmend.training.adreft.random_case import random_cases
from roadmend.training.adreft.recalibration import fit_logits, fold, sigmoids
from roadmend.training.adreft.reliability import reliability
from roadmend.training.adreft.scoring import monitor_scores, said_logits
from roadmend.training.adreft.stage import PRACTICE_STATE, Report, StageRun, Tensors, TrainingSubject, spread
from roadmend.training.adreft.token_rows import TokenRows
from roadmend.training.closed_loop import EpisodeCase

GUIDE = "futures-guide-{}.safetensors"  # the model that drives along in a round


class FuturesPractice:
    """What a training on futures does beside what every training does."""

    def __init__(
        self,
        configuration: TrainingConfiguration,
        subject: TrainingSubject,
        *,
        seed: int,
        device: str,
        mapper: Mapper,
        work: Path,
        report: Report,
    ) -> None:
        """As ``pipeline.Pipeline``.

        Raises:
            InputError: the model to start with is missing, or has other networks.
        """
        self._configuration, self._section = configuration, configuration.futures
        self._model = configuration.model.configuration()
        self._subject, self._seed, self._device = subject, seed, device
        self._mapper, self._work, self._report = mapper, work, report
        self._harmless: tuple[TokenRows, NDArray[np.float32], NDArray[np.int64]] | None = None
        start = self._section.start
        checkpoint = None if start is None else load_start(find_model(start, "adreft-"), self._model)
        self._start = None if checkpoint is None else checkpoint.tensors
        self.ancestry = [] if checkpoint is None else [checkpoint.digest, *checkpoint.header["ancestry"]]

    def run(self) -> tuple[Tensors, str]:
        """Practise, round after round, on all moments so far; returns the tensors and the digest of the moments.

        Raises:
            InputError: a case or a file is unusable.
            SimulationError: SUMO failed, or a worker process died.
        """
        practice, section = self._configuration.practice, self._section
        gathered: list[CaseMoments] = []
        tensors, digest = self._start, ""
        for number in range(practice.rounds):
            gathered += self._gather(number, tensors)
            moments = MomentSet.join(gathered, section.base_rate, section.weight_exponent)
            state = self._work / PRACTICE_STATE.format(number)
            run = StageRun(self._seed + number, self._device, state, self._work / "tensorboard" / f"practice-{number}")
            own = practice.of_round(number)
            stage = FuturesStage(self._model, own, moments, run, tensors)

            def report(figures: PracticeFigures, size: int = len(moments), of: int = own.epochs) -> None:
                losses = f"losses {figures.monitor_loss:.4f} and {figures.value_loss:.4f}"
                self._report("practice", figures.epoch, of, f"{size} moments, {losses}")

            tensors, digest = self._recalibrated(stage.run(report)), moments.digest
        assert tensors is not None
        return tensors, digest

    def _gather(self, number: int, tensors: Tensors | None) -> list[CaseMoments]:
        """The moments of one round: of the policy alone, later of the model so far at work."""
        section, guide, digest = self._section, None, ""
        if number and tensors is not None:
            guide = self._work / GUIDE.format(number)
            digest = save_model(guide, self._model, tensors, self.calibrate(tensors))
        jobs = [
            (
                driver.policy,
                [*spread(driver.training, section.cases), *random_cases(driver.policy, section.random_cases)],
            )
            for driver in (self._subject.driver, *self._subject.also)
        ]
        plan = self._plan(digest)
        return [
            entry
            for policy, cases in jobs
            for entry in self._moments(policy, cases, plan, guide, f"moments {number}: {policy}")
        ]

    def _moments(
        self, policy: str, cases: Sequence[EpisodeCase], plan: MomentPlan, guide: Path | None, what: str
    ) -> list[CaseMoments]:
        done, looked, dangerous = 0, 0, 0

        def count(found: CaseMoments) -> None:
            nonlocal done, looked, dangerous
            done, looked = done + 1, looked + len(found)
            dangerous += int(np.count_nonzero(found.danger))
            self._report(what, done, len(cases), f"{looked} moments, {dangerous} with a future that violates")

        recipe = Recipe(policy, self._model.tokenizer, 1)
        return gather_moments(cases, recipe, plan, self._work / "moments", self._mapper, count, guide)

    def _plan(self, guide: str) -> MomentPlan:
        section = self._section
        return MomentPlan(
            section.moments,
            section.futures,
            section.actions,
            section.harmless,
            section.pulse,
            section.pulsed,
            self._seed,
            guide,
        )

    def calibrate(self, tensors: Tensors, touched: float | None = None) -> float:
        """lambda_safe: few validation drives that end well ever score above it.

        Args:
            tensors: of the networks.
            touched: share of those that do; None for the section's.

        Raises:
            InputError: there is none, or a case cannot be driven.
            SimulationError: SUMO failed, or a worker process died.
        """
        if self._harmless is None:
            self._harmless = self._harmless_drives()
        rows, actions, drives = self._harmless
        scores = monitor_scores(self._model, tensors, rows, actions, self._mapper)
        highest = np.maximum.reduceat(scores, drives)
        return calibrate_untouched(highest, self._section.touched if touched is None else touched)

    def _harmless_drives(self) -> tuple[TokenRows, NDArray[np.float32], NDArray[np.int64]]:
        """Frames of all of them with the policy's actions, and where each drive begins."""
        subject = self._subject
        policy = subject.driver.policy
        successes = [case for case in subject.validation if not case.is_violation]
        cases = [*successes, *random_cases(policy, self._section.random_validation, validation=True)]
        recipe = Recipe(policy, self._model.tokenizer, self._configuration.frames.validation_stride)
        found: list[CaseFrames] = []

        def report(frames: CaseFrames) -> None:
            found.append(frames)
            self._report("harmless drives", len(found), len(cases), "")

        gather_frames(cases, recipe, self._work / "frames", self._mapper, report)
        harmless = [frames for frames in found if frames.outcome == EventKind.GOAL.name and len(frames)]
        if not harmless:
            mend = "give a corpus with successes, or set futures.random_validation"
            raise InputError("validation split", "holds no drive that ends well", mend)
        counts = np.concatenate([frames.counts for frames in harmless]).astype(np.int64)
        rows = TokenRows(np.concatenate([frames.tokens for frames in harmless]), np.concatenate([[0], counts.cumsum()]))
        begins = np.cumsum([0, *map(len, harmless)])[:-1]
        return rows, np.concatenate([frames.action for frames in harmless]), begins

    def _validation_moments(self) -> tuple[MomentSet, NDArray[np.int64]]:
        """Moments of validation drives at the base rate, and of which case each is."""
        policy = self._subject.driver.policy
        drawn = random_cases(policy, self._section.random_validation, validation=True)
        cases = [*self._subject.validation, *drawn]
        gathered = self._moments(policy, cases, self._plan(""), None, "validation moments")
        moments = MomentSet.join(gathered, self._section.base_rate, 1.0)
        return moments, np.repeat(np.arange(len(gathered)), [len(entry) for entry in gathered])

    def _recalibrated(self, tensors: Tensors) -> Tensors:
        if not self._section.recalibrate:
            return tensors
        moments, _ = self._validation_moments()
        said = said_logits(self._model, tensors, moments, moments.action, self._mapper)
        seen, weight = moments.critical.astype(np.float64), moments.judged.astype(np.float64)
        monitor, danger = (fit_logits(logits, seen, weight) for logits in said)
        return fold(self._model, tensors, monitor, danger)

    def judge(self, tensors: Tensors, threshold: float) -> dict[str, Any]:
        """How reliable the monitor is on moments of validation drives, for a model's header.

        Where these moments have made probabilities of its scores, each half of the cases is judged with what the other
        half makes of them.

        Raises:
            InputError: a case cannot be driven.
            SimulationError: SUMO failed, or a worker process died.
        """
        moments, cases = self._validation_moments()
        logits, _ = said_logits(self._model, tensors, moments, moments.action, self._mapper)
        seen, weight = moments.critical.astype(np.float64), moments.judged.astype(np.float64)
        scores = sigmoids(logits)
        above, likely = scores > threshold, seen >= 0.5
        if self._section.recalibrate:
            odd = cases % 2 == 1
            for judged, other in ((odd, ~odd), (~odd, odd)):
                if judged.any() and other.any():
                    slope, offset = fit_logits(logits[other], seen[other], weight[other])
                    scores[judged] = sigmoids(slope * logits[judged] + offset)
        return {
            **asdict(reliability(scores, seen, weight)),
            "recognised": float(above[likely].mean()) if likely.any() else None,  # of moments likely to end so
            "alarmed": float(above[~likely].mean()) if not likely.all() else None,  # of the others, unweighted
        }
