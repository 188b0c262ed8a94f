"""The experiment of SERA for one policy: base, random, initial and full over some seeds, half a bank, and a sweep."""

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from harness.forgetting import forgotten, forgotten_anew, redrawn
from harness.sera_kept_runs import KeptRuns, kept_epochs
from harness.sera_plan import Evaluated, SeraPlan, halves
from roadmend.core.errors import InputError
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.summary import MEASURES
from roadmend.sera.bank import Bank
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.recommendation import Recommendation, recommend, shares
from roadmend.sera.reflection import Pick
from roadmend.training.few_shot_settings import FewShotSettings
from roadmend.world.scenario import Scenario

ARMS = ("base", "random", "initial", "full")
HALF_BANK = "half_bank"
Patterns = Callable[[Sequence[Scenario]], tuple[FailurePattern, ...]]  # of the failures in some scenarios


@dataclass
class Experiment:
    """What one policy is put through."""

    model: Path
    plan: SeraPlan
    settings: FewShotSettings
    evaluated: Sequence[Evaluated]
    bank: Bank
    kept_runs: KeptRuns
    patterns: Patterns
    in_depth: bool  # with half the bank and the sweep

    def run(self) -> dict[str, Any]:
        """All figures as plain values; no row of the sweep where it was not asked for.

        Raises:
            InputError: the policy fails nowhere in the half that is analysed.
        """
        seeds = [self._seed(seed) for seed in range(self.plan.seeds)]
        return {"seeds": seeds, "sweep": self._sweep() if self.in_depth else []}

    def _seed(self, seed: int) -> dict[str, Any]:
        analysed, measured = halves(self.evaluated, seed)
        base = self._measures(self.model, measured)
        failed = self._failed(analysed)
        hard = failed[: self.plan.validation]
        chosen = self._recommended(failed, seed)
        arms: dict[str, Any] = {"base": means(base)}
        kept: dict[str, int] = {}
        found, models = {}, {}
        selections = {"random": chosen.random, "initial": chosen.initial, "full": chosen.refined}
        if self.in_depth:
            selections[HALF_BANK] = self._recommended(failed, seed, self._half_of_bank(seed)).refined
        for arm, picks in selections.items():
            tuned = self.kept_runs.tune(self.model, self._scenarios(picks), self.settings, seed, hard)
            kept[arm] = kept_epochs(tuned)
            models[arm] = tuned if kept[arm] else self.model  # the weights are the same
            found[arm] = self._measures(models[arm], measured)
            arms[arm] = means(found[arm])
        anew = redrawn(measured, base)
        forgetting = {arm: forgotten(measured, base, after) for arm, after in found.items()}
        forgetting["full"] |= forgotten_anew(
            self.kept_runs.drive(self.model, anew), self.kept_runs.drive(models["full"], anew)
        )
        return {
            "seed": seed,
            "measured": len(measured),
            "scenarios": len(chosen.refined),
            "swaps": len(chosen.swaps),
            "arms": arms,
            "kept_epochs": kept,
            "forgetting": forgetting,
        }

    def _failed(self, analysed: Sequence[Evaluated]) -> list[Scenario]:
        """The scenarios of the half that the policy does not complete without fault, hard and ordinary ones mixed."""
        measures = self._measures(self.model, analysed)
        failed = [each.scenario for each, one in zip(analysed, measures, strict=True) if not one.success]
        random.Random(0).shuffle(failed)
        return failed

    def _recommended(self, failed: Sequence[Scenario], seed: int, without: Sequence[str] = ()) -> Recommendation:
        patterns = self.patterns(failed)
        if not patterns:
            raise InputError("the evaluation set", f"shows no failure of {self.model.stem}", "take more scenarios")
        return recommend(self.bank, patterns, shares(patterns, self.plan.scenarios), exclude=without, seed=seed)

    def _half_of_bank(self, seed: int) -> list[str]:
        """Digests of the half of the bank that is taken away."""
        digests = sorted(entry.digest for entry in self.bank.entries())
        return random.Random(f"roadmend/sera/half/{seed}").sample(digests, len(digests) // 2)

    def _sweep(self) -> list[dict[str, Any]]:
        """Epochs and learning rates one by one on the full selection of the first seed, without the guard."""
        analysed, measured = halves(self.evaluated, 0)
        scenarios = self._scenarios(self._recommended(self._failed(analysed), 0).refined)
        rows = []
        for epochs in self.plan.sweep.epochs:
            for rate in self.plan.sweep.learning_rates:
                settings = self.settings.model_copy(update={"epochs": epochs, "learning_rate": rate, "keep": "last"})
                tuned = self.kept_runs.tune(self.model, scenarios, settings, 0, ())
                rows.append({"epochs": epochs, "learning_rate": rate, **means(self._measures(tuned, measured))})
        return rows

    def _measures(self, model: Path, evaluated: Sequence[Evaluated]) -> list[DrivingMeasures]:
        return self.kept_runs.drive(model, [each.scenario for each in evaluated])

    def _scenarios(self, picks: Sequence[Pick]) -> list[Scenario]:
        entries = [self.bank.entry(pick.number) for pick in picks]
        return [entry.scenario for entry in entries if entry.scenario is not None]


def means(measures: Sequence[DrivingMeasures]) -> dict[str, float | None]:
    """The four measures over some scenarios."""
    values: Mapping[str, list[float]] = {
        "driving_score": [one.driving_score for one in measures],
        "success_rate": [100.0 * one.success for one in measures],
        "efficiency": [one.efficiency for one in measures if one.efficiency is not None],
        "comfortness": [one.comfortness for one in measures if one.comfortness is not None],
    }
    return {name: fmean(values[name]) if values[name] else None for name in MEASURES}
