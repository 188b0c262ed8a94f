"""A search from its first point to its budget, over as many calls as it takes."""

import os
import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.journal import Key, entry_key
from roadmend.core.parameters import Parameters as AnyParameters
from roadmend.measures.driver import driver_key
from roadmend.networks.checkpoint import SUFFIX
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY
from roadmend.search.attempt import CRASH
from roadmend.search.evaluation import Evaluation, NamedPoint, Subject, Trial
from roadmend.search.ledger import FOUND, Ledger, LedgerEntry, RerunCommand
from roadmend.search.policy_model import policy_model
from roadmend.search.registry import TECHNIQUE_REGISTRY, make_technique
from roadmend.world.case_name import case_name
from roadmend.world.families import FAMILY_REGISTRY, family_of
from roadmend.world.scenario_file import outside_content, save_scenario
from roadmend.world.space import Parameters

Evaluate = Callable[[Sequence[NamedPoint]], Iterator[Evaluation]]


@dataclass(frozen=True, slots=True)
class Campaign:
    """What a search does. Its budget is no part of it: a search may go on with a larger one."""

    subject: Subject
    technique: str
    parameters: AnyParameters

    @property
    def settings(self) -> dict[str, Any]:
        """All that decides what is found, as plain values."""
        subject = self.subject
        model = policy_model(subject.policy)
        foreign = (*TECHNIQUE_REGISTRY.find(self.technique).modules, *FAMILY_REGISTRY.find(subject.family).modules)
        return {
            "family": subject.family,
            "technique": self.technique,
            "policy": subject.policy,
            "repair": subject.method,
            "seed": subject.seed,
            "parameters": self.parameters.model_dump(mode="json"),
            "roadmend": __version__,
            **({} if model is None else {"model": model}),
            "code": entry_key([__name__, *foreign], driver_key(subject.policy, subject.method, subject.repair)),
        }

    def name(self, index: int) -> str:
        """Name of the scenario of one evaluated point."""
        subject = self.subject
        labels = (
            FAMILY_REGISTRY.find(subject.family).label,
            POLICY_REGISTRY.find(subject.policy).label,
            METHOD_REGISTRY.find(subject.method).label,
            TECHNIQUE_REGISTRY.find(self.technique).label,
        )
        return case_name(labels, subject.seed, index)


@dataclass(frozen=True, slots=True)
class CampaignSummary:
    """What a search has found."""

    evaluated: int
    violations: int
    distinct: int  # violations with different trajectories
    first_violation: int | None  # evaluations until the first one, itself included
    crashes: int
    outcomes: dict[str, int] = field(default_factory=dict)


def summarise(entries: Sequence[LedgerEntry]) -> CampaignSummary:
    """Count what is in a ledger."""
    violations = [entry for entry in entries if entry.evaluation.is_violation]
    outcomes = Counter(entry.evaluation.outcome for entry in entries)
    return CampaignSummary(
        evaluated=len(entries),
        violations=len(violations),
        distinct=len({entry.evaluation.digest for entry in violations}),
        first_violation=violations[0].index + 1 if violations else None,
        crashes=outcomes[CRASH],
        outcomes=dict(sorted(outcomes.items())),
    )


def run_campaign(
    campaign: Campaign,
    ledger: Ledger,
    evaluate: Evaluate,
    budget: int,
    report: Callable[[LedgerEntry], None] = lambda _entry: None,
) -> list[Trial]:
    """Search until the ledger has ``budget`` entries.

    The technique is led through what the ledger holds already, so it goes on as if it had never stopped.

    Args:
        campaign: what to do.
        ledger: where to keep it, opened with the campaign's settings.
        evaluate: runs points; one evaluation each, in their order.
        budget: evaluations in all, earlier calls included.
        report: called for every new entry.

    Returns:
        The points of the first ``budget`` entries and what they came to.

    Raises:
        InputError: the ledger does not belong to this search, or cannot be written.
        SimulationError: a worker process died.
    """
    technique = make_technique(
        campaign.technique, family_of(campaign.subject.family).space, campaign.subject.seed, campaign.parameters
    )
    done: list[Trial] = []
    while (start := len(done)) < budget:
        points = technique.propose()
        known = _known(campaign, ledger, start, points)
        fresh = points[known : budget - start]
        named = [NamedPoint(campaign.name(index), point) for index, point in enumerate(fresh, start + known)]
        for index, (point, evaluation) in enumerate(zip(fresh, evaluate(named), strict=True), start + known):
            trial = Trial(point, evaluation)
            ledger.add(_entry(campaign, ledger, index, trial))
            report(ledger.entries[-1])
        entries = ledger.entries[start : start + len(points)]
        trials = [Trial(point, entry.evaluation) for point, entry in zip(points, entries, strict=False)]
        done += trials
        if len(trials) < len(points):
            break  # the budget ends within the batch: it is learned from when the search goes on
        technique.learn(trials)
    return done[:budget]


def _known(campaign: Campaign, ledger: Ledger, start: int, points: Sequence[Parameters]) -> int:
    """How many points of a batch are in the ledger."""
    entries = ledger.entries[start : start + len(points)]
    for point, entry in zip(points, entries, strict=False):
        if _key(campaign, entry.index, point) != entry.key:
            what = (
                f"evaluation {entry.index} is not what this version of roadmend would have tried, or of another network"
            )
            raise InputError(str(ledger.folder), what, "choose another folder")
    return len(entries)


def _entry(campaign: Campaign, ledger: Ledger, index: int, trial: Trial) -> LedgerEntry:
    """The ledger's line; a violation's scenario is written first, so that no line names a file that is not there."""
    key = _key(campaign, index, trial.parameters)
    if not trial.evaluation.is_violation:
        return LedgerEntry(index, key, trial.evaluation)
    subject, name = campaign.subject, campaign.name(index)
    path = f"{FOUND}/{name}.yaml"
    save_scenario(subject.scenario(trial.parameters, name), ledger.folder / path)
    policy, method = (_seen_from(ledger.folder, given) for given in (subject.policy, subject.method))
    command = shlex.join(["roadmend", "run", "--scenario", path, "--policy", policy, "--repair", method])
    return LedgerEntry(index, key, trial.evaluation, RerunCommand(path, command, policy, method))


def _seen_from(folder: Path, given: str) -> str:
    """A name as it is; a model file's path, which was given in the user's folder, as it is seen from another one."""
    if not given.endswith(SUFFIX) or Path(given).is_absolute():
        return given
    return os.path.relpath(Path(given).resolve(), folder.resolve())


def _key(campaign: Campaign, index: int, point: Parameters) -> Key:
    """Of an entry in the ledger of one search, whose settings say what else decides what a point comes to."""
    try:
        content = outside_content(campaign.subject.scenario(point, "point"))
    except Exception:  # noqa: BLE001 - it is told as what the point came to
        content = None
    return entry_key([__name__], index, point, content)
