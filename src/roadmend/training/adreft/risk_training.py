"""A model of ADReFT gets a risk monitor; its other networks stay as they are."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.measures.monitor import separation_of
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.repair.adreft.configuration import read_configuration
from roadmend.repair.adreft.model import KIND, AdreftModel
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.risk_monitor import RiskConfiguration, RiskMonitor
from roadmend.training.adreft.case_risks import CaseRisks, RiskDrive, RiskPlan, gather_risks
from roadmend.training.adreft.change_drives import changes_of_case
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.need_drives import needs_of_case
from roadmend.training.adreft.random_case import random_cases
from roadmend.training.adreft.risk_learning import learn_risks, risks_of, threshold_by_drives, threshold_by_ticks
from roadmend.training.adreft.risk_settings import ChangeSettings, NeedSettings, RiskSettings
from roadmend.training.adreft.stage import RepairedPolicy, Report
from roadmend.training.adreft.successor import save_successor
from roadmend.training.closed_loop import EpisodeCase


@dataclass(frozen=True, slots=True)
class RiskKind:
    """What one risk monitor is asked about, and how it learns of it."""

    name: str  # of its tensors, and of its field in the model's configuration
    what: str  # it judges, in the plural
    settings: type[RiskSettings]
    drive: RiskDrive
    threshold: Callable[[NDArray[np.float64], Sequence[CaseRisks], float], float]  # of risks, cases, false alarms
    is_shared: bool  # what is gathered of a policy under its own model serves the models of others as well


KINDS = {
    "need": RiskKind("need", "moments", NeedSettings, needs_of_case, threshold_by_drives, is_shared=True),
    "changes": RiskKind("change", "lane changes", ChangeSettings, changes_of_case, threshold_by_ticks, is_shared=False),
}


@dataclass(frozen=True, slots=True)
class LearnedRisks:
    """What came of it; validation is ordinary driving of the first policy, never learned from."""

    threshold: float
    judged: int  # moments or lane changes learned from
    collided: int  # of them
    validation_judged: int
    validation_collided: int
    separation: float | None  # see ``measures.monitor.separation_of``, on validation
    caught: float | None  # share of those that ended badly on validation that are above the threshold


def model_beside(kind: RiskKind, policy: str, model: Path, tokenizer: str) -> Path:
    """The model that finds the ticks of the drives of a further policy: ``model``, or where that serves all its own one.

    Args:
        kind: of the monitor.
        policy: name of the further policy; one that has no model shipped, or one that sees by other tokens, is looked at
            by ``model``.
        model: that gets the monitor.
        tokenizer: name of that model's.
    """
    if kind.is_shared:
        with suppress(InputError):
            shipped = find_model(policy, "adreft-")
            if read_configuration(str(shipped), load_checkpoint(shipped, KIND).header).tokenizer == tokenizer:
                return shipped
    return model


def train_risk_monitor(
    kind: RiskKind,
    model: Path,
    out: Path,
    drivers: Sequence[RepairedPolicy],
    settings: RiskSettings,
    *,
    seed: int,
    mapper: Mapper,
    work: Path,
    command: str,
    report: Report = lambda _what, _done, _total, _how: None,
) -> LearnedRisks:
    """Gather drives, learn of what came of them, set the threshold, and write the model anew.

    Args:
        kind: which monitor.
        model: of ADReFT.
        out: the new file.
        drivers: whose drives are learned from; the model is for the first.
        settings: how.
        seed: of all chance.
        mapper: runs episodes side by side.
        work: folder of what was gathered; what is there is not driven again.
        command: that asked for it, without places on this machine.
        report: called as things go on.

    Raises:
        InputError: the model, a case or a file is unusable, or nothing ended badly.
        SimulationError: SUMO failed, or a worker process died.
    """
    checkpoint = load_checkpoint(model, KIND)
    AdreftModel.of(checkpoint, str(model))  # whatever does not fit is said here
    before = read_configuration(str(model), checkpoint.header)
    if settings.history and not make_tokenizer(before.tokenizer).has_ego:
        what = f"has no token of the ego's own among '{before.tokenizer}', which its history would belong to"
        raise InputError(str(model), what, "give --set history=false")

    def gather(driver: RepairedPolicy, cases: Sequence[EpisodeCase], what: str, *, plain: bool) -> list[CaseRisks]:
        chosen = [case for case in cases if case.family in settings.families]
        done: list[CaseRisks] = []

        def count(entry: CaseRisks) -> None:
            done.append(entry)
            judged, bad = sum(map(len, done)), sum(int(each.collided.sum()) for each in done)
            report(f"{what}: {driver.policy}", len(done), len(chosen), f"{judged} {kind.what}, {bad} end badly")

        looks = model if driver is drivers[0] else model_beside(kind, driver.policy, model, before.tokenizer)
        digest = load_checkpoint(looks, KIND).digest
        plan = RiskPlan(
            str(looks),
            digest,
            settings.searched_drives,
            settings.horizon,
            plain=plain,
            history=settings.history,
            seed=seed,
        )
        recipe = Recipe(driver.policy, before.tokenizer, 1)
        return gather_risks(kind.drive, chosen, recipe, plan, work, mapper, count)

    learned: list[CaseRisks] = []
    for driver in drivers:
        learned += gather(driver, driver.training, "searched", plain=False)
        learned += gather(driver, random_cases(driver.policy, settings.random_cases), "random", plain=False)
    drawn = random_cases(drivers[0].policy, settings.validation_cases, validation=True)
    validation = gather(drivers[0], drawn, "validation", plain=True)
    collided, seen = (np.concatenate([each.collided for each in entries]) for entries in (learned, validation))
    if not collided.any() or not (seen < 0.5).any():
        raise InputError(str(model), f"the {kind.what} of its drives tell nothing", "set more random_cases")
    kind.threshold(np.zeros(len(seen)), validation, settings.false_alarms)  # what it lacks is said before it is learned
    configuration = RiskConfiguration(
        encoder=before.encoder,
        head=settings.head,
        threshold=0.0,
        horizon=settings.horizon,
        history=settings.history,
    )
    shape = before.encoder.model_copy(update={"attributes": configuration.attributes(before.encoder.attributes)})
    configuration = configuration.model_copy(update={"encoder": shape})

    def learning(epoch: int, loss: float) -> None:
        report("learning", epoch, settings.epochs, f"loss {loss:.4f}")

    prefix = f"{kind.name}."
    tensors = learn_risks(configuration, settings, learned, checkpoint.tensors, prefix, seed, learning)
    risks = risks_of(RiskMonitor(configuration, tensors, prefix), validation)
    threshold = kind.threshold(risks, validation, settings.false_alarms)
    configuration = configuration.model_copy(update={"threshold": threshold})
    found = LearnedRisks(
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
        **asdict(found),
    }
    kept = {name: value for name, value in checkpoint.tensors.items() if not name.startswith(prefix)}
    changed = before.model_copy(update={kind.name: configuration})
    save_successor(out, checkpoint, {**kept, **tensors}, changed, **{kind.name: made})
    return found
