"""Rounds of reinforcement fine-tuning by rollouts: the model drives, and its adapter learns from what came of it."""

from collections.abc import Sequence
from pathlib import Path

from roadmend.core.fanout import Mapper
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.training.adreft.case_rollouts import CaseRollouts
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.network import save_model
from roadmend.training.adreft.random_case import random_cases
from roadmend.training.adreft.rollouts import RolloutPlan, gather_rollouts
from roadmend.training.adreft.rollouts_configuration import RolloutsSection
from roadmend.training.adreft.rollouts_stage import RolloutsStage, TuningFigures
from roadmend.training.adreft.stage import Report, Tensors, TrainingSubject, spread
from roadmend.training.closed_loop import EpisodeCase

GUIDE = "rollouts-guide-{}.safetensors"  # the model that drives in a round


class RolloutsTuning:
    """Drives and learns, round after round, on all rollouts so far."""

    def __init__(
        self,
        model: ModelConfiguration,
        section: RolloutsSection,
        subject: TrainingSubject,
        *,
        seed: int,
        device: str,
        mapper: Mapper,
        work: Path,
        report: Report,
    ) -> None:
        """As ``pipeline.Pipeline``."""
        self._model, self._section, self._subject = model, section, subject
        self._seed, self._device = seed, device
        self._mapper, self._work, self._report = mapper, work, report

    def run(self, tensors: Tensors, threshold: float) -> tuple[Tensors, list[TuningFigures]]:
        """The networks with the adapter tuned, and what each round came to.

        Args:
            tensors: of the networks to begin with.
            threshold: above which the monitor asks the adapter.

        Raises:
            InputError: a case is unusable, or shows nothing to learn from.
            SimulationError: SUMO failed, or a worker process died.
        """
        gathered: list[CaseRollouts] = []
        history: list[TuningFigures] = []
        for number in range(self._section.rounds):
            gathered += self._gather(number, tensors, threshold)
            stage = RolloutsStage(self._model, self._section, gathered, tensors, self._seed + number, self._device)
            tensors, figures = stage.run()
            history.append(figures)
            found = f"gain {figures.gained_before:.2f} -> {figures.gained:.2f} a moment, epoch {figures.epoch}"
            self._report("fine-tuning", number + 1, self._section.rounds, found)
        return tensors, history

    def _gather(self, number: int, tensors: Tensors, threshold: float) -> list[CaseRollouts]:
        guide = self._work / GUIDE.format(number)
        digest = save_model(guide, self._model, tensors, threshold)
        section, cases = self._section, self._cases()
        plan = RolloutPlan(
            section.moments, section.futures, section.actions, section.score, section.chance, self._seed, digest
        )
        done, looked = 0, 0

        def count(found: CaseRollouts) -> None:
            nonlocal done, looked
            done, looked = done + 1, looked + len(found)
            self._report(f"rollouts {number}", done, len(cases), f"{looked} moments")

        recipe = Recipe(self._subject.driver.policy, self._model.tokenizer, 1)
        return gather_rollouts(cases, recipe, plan, guide, self._work / "rollouts", self._mapper, count)

    def _cases(self) -> Sequence[EpisodeCase]:
        section, driver = self._section, self._subject.driver
        kinds = [[case for case in driver.training if case.is_violation is kind] for kind in (True, False)]
        known = [
            case
            for cases, number in zip(kinds, (section.violation_cases, section.success_cases), strict=True)
            for case in spread(cases, number)
        ]
        return [*known, *random_cases(driver.policy, section.random_cases)]
