"""A model of ADReFT gets a monitor of lane changes; its other networks stay as they are."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.measures.monitor import separation_of
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.repair.adreft.change_monitor import PREFIX, ChangeConfiguration, ChangeMonitor
from roadmend.repair.adreft.configuration import read_configuration
from roadmend.repair.adreft.model import KIND, AdreftModel
from roadmend.training.adreft.change_drives import CaseChanges, ChangePlan, gather_changes
from roadmend.training.adreft.change_learning import learn_changes, risks_of, threshold_of
from roadmend.training.adreft.change_settings import ChangeSettings
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.random_case import random_cases
from roadmend.training.adreft.stage import RepairedPolicy, Report
from roadmend.training.adreft.successor import save_successor
from roadmend.training.closed_loop import EpisodeCase


@dataclass(frozen=True, slots=True)
class LearnedChanges:
    """What came of it; validation is ordinary driving of the first policy, never learned from."""

    threshold: float
    changes: int  # learned from
    collided: int  # of them
    validation_changes: int
    validation_collided: int
    separation: float | None  # see ``measures.monitor.separation_of``, on validation
    caught: float | None  # share of those that ended badly on validation that would be held back


def train_changes(
    model: Path,
    out: Path,
    drivers: Sequence[RepairedPolicy],
    settings: ChangeSettings,
    *,
    seed: int,
    mapper: Mapper,
    work: Path,
    command: str,
    report: Report = lambda _what, _done, _total, _how: None,
) -> LearnedChanges:
    """Gather lane changes, learn of them, set the threshold, and write the model anew.

    Args:
        model: of ADReFT, that repairs the drives.
        out: the new file.
        drivers: whose changes are learned from; the model is for the first.
        settings: how.
        seed: of all chance.
        mapper: runs episodes side by side.
        work: folder of what was gathered; what is there is not driven again.
        command: that asked for it, without places on this machine.
        report: called as things go on.

    Raises:
        InputError: the model, a case or a file is unusable, or no change ended badly.
        SimulationError: SUMO failed, or a worker process died.
    """
    checkpoint = load_checkpoint(model, KIND)
    AdreftModel.of(checkpoint, str(model))  # whatever does not fit is said here
    before = read_configuration(str(model), checkpoint.header)

    def gather(driver: RepairedPolicy, cases: Sequence[EpisodeCase], what: str, *, plain: bool) -> list[CaseChanges]:
        done: list[CaseChanges] = []

        def count(entry: CaseChanges) -> None:
            done.append(entry)
            begun, bad = sum(map(len, done)), sum(int(each.collided.sum()) for each in done)
            report(f"{what}: {driver.policy}", len(done), len(cases), f"{begun} changes, {bad} end badly")

        plan = ChangePlan(
            str(model), checkpoint.digest, settings.searched_drives, settings.horizon, plain=plain, seed=seed
        )
        return gather_changes(cases, Recipe(driver.policy, before.tokenizer, 1), plan, work, mapper, count)

    def chosen(cases: Sequence[EpisodeCase]) -> list[EpisodeCase]:
        return [case for case in cases if case.family in settings.families]

    learned: list[CaseChanges] = []
    for driver in drivers:
        learned += gather(driver, chosen(driver.training), "searched", plain=False)
        learned += gather(driver, chosen(random_cases(driver.policy, settings.random_cases)), "random", plain=False)
    drawn = random_cases(drivers[0].policy, settings.validation_cases, validation=True)
    validation = gather(drivers[0], chosen(drawn), "validation", plain=True)
    collided, seen = (np.concatenate([each.collided for each in entries]) for entries in (learned, validation))
    if not collided.any() or not (seen < 0.5).any():
        raise InputError(str(model), "no lane change of its drives tells anything", "set more random_cases")
    configuration = ChangeConfiguration(
        encoder=before.encoder, head=settings.head, threshold=0.0, horizon=settings.horizon
    )

    def learning(epoch: int, loss: float) -> None:
        report("learning", epoch, settings.epochs, f"loss {loss:.4f}")

    tensors = learn_changes(configuration, settings, learned, checkpoint.tensors, seed, learning)
    risks = risks_of(ChangeMonitor(configuration, tensors), validation)
    threshold = threshold_of(risks, seen, settings.held)
    configuration = configuration.model_copy(update={"threshold": threshold})
    learned_changes = LearnedChanges(
        threshold,
        len(collided),
        int(collided.sum()),
        len(seen),
        int(seen.sum()),
        separation_of(risks, seen > 0.5),
        float(np.mean(risks[seen > 0.5] > threshold)) if seen.any() else None,
    )
    made: dict[str, Any] = {
        "command": command,
        "seed": seed,
        "settings": settings.model_dump(mode="json"),
        "drivers": {driver.policy: driver.as_header() for driver in drivers},
        **asdict(learned_changes),
    }
    kept = {name: value for name, value in checkpoint.tensors.items() if not name.startswith(PREFIX)}
    changed = before.model_copy(update={"change": configuration})
    save_successor(out, checkpoint, {**kept, **tensors}, changed, changes=made)
    return learned_changes
