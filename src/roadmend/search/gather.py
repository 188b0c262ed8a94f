"""Gathers a corpus: searches every family until its splits are full, and runs each case again before it is taken."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from roadmend.core.fanout import Mapper, fan_out
from roadmend.core.journal import InUseError, Journal
from roadmend.core.outcome import EventKind
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.search.campaign import Campaign, run_campaign
from roadmend.search.corpus_plan import CorpusPlan, SplitPlan, fresh_plan
from roadmend.search.evaluation import Trial, evaluate
from roadmend.search.ledger import LEDGER, Ledger, LedgerEntry
from roadmend.search.persistence import FORMAT as PERSISTENCE_FORMAT
from roadmend.search.persistence import PersistenceTeller
from roadmend.search.policy_model import policy_model
from roadmend.search.rerun import FORMAT as RERUN_FORMAT
from roadmend.search.rerun import Rerunner, agrees
from roadmend.search.selection import Picker, shares
from roadmend.world.corpus import Case, Corpus, sorted_cases, told_of
from roadmend.world.families import FAMILIES, FAMILY_REGISTRY, family_of
from roadmend.world.point_text import used_parameters

RERUNS = "reruns.jsonl"
PERSISTENCE = "persistence.jsonl"


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a gathering stands."""

    stage: str
    done: int  # of the stage
    total: int
    accepted: int  # cases, over all families and splits
    wanted: int


Report = Callable[[Progress], None]


@dataclass
class _Source:
    """One finished search, or as much as there is of it."""

    campaign: Campaign
    trials: list[Trial]
    taken: set[int] = field(default_factory=set)  # indices
    pickers: dict[EventKind, Picker] = field(default_factory=dict)

    def of_outcome(self, outcome: EventKind) -> list[tuple[int, Trial]]:
        """Index and trial of what is not taken yet; of collisions, those that are the ego's fault."""
        wants_violation = outcome is EventKind.COLLISION
        return [
            (index, trial)
            for index, trial in enumerate(self.trials)
            if trial.evaluation.outcome == outcome.name
            and trial.evaluation.is_violation == wants_violation
            and index not in self.taken
        ]


class Gatherer:
    """Fills splits, one family after the other."""

    def __init__(
        self,
        plan: CorpusPlan,
        policy: str,
        folder: Path,
        rerunner: Rerunner,
        teller: PersistenceTeller,
        mapper: Mapper,
        *,
        is_partial: bool = False,
    ) -> None:
        """Start without cases.

        Args:
            plan: what to gather.
            policy: who drives.
            folder: of the policy's searches; each is in FAMILY/SPLIT-NUMBER below it.
            rerunner: runs candidates again.
            teller: tells how persistent they are.
            mapper: runs the points of a search side by side.
            is_partial: make do with what the searches that are there hold, and search nothing.
        """
        self._plan, self._policy, self._folder = plan, policy, folder
        self._rerunner, self._teller, self._mapper = rerunner, teller, mapper
        self._is_partial = is_partial
        self._digests: set[str] = set()
        self.cases: list[Case] = []
        self.dropped = 0
        self.fleeting = 0  # violations that do not come in enough of their futures
        self.shortages: list[str] = []  # what could not be filled
        self.report: Report = lambda _progress: None
        self.wanted = 0

    def gather(self, families: Sequence[str], report: Report) -> None:
        """Fill every split of some families.

        Raises:
            InputError: a search's folder holds another search, is in use or cannot be written.
            SimulationError: a worker process died.
        """
        self.report, self.wanted = report, self._plan.wanted * len(families)
        for family in families:
            for name, split in self._plan.splits():
                self._fill(family, name, split)

    def _fill(self, family: str, name: str, split: SplitPlan) -> None:
        sources: list[_Source] = []
        violations: list[Case] = []
        for number in range(self._plan.most_campaigns):
            if len(violations) >= split.violations and (sources or not split.successes):
                break
            campaign = split.campaign(family, self._policy, number)
            source = self._search(campaign, f"{family}/{name}-{number}", split.budget)
            if source is None:
                continue
            sources.append(source)
            left = split.violations - len(violations)
            most = left if split.most_per_campaign is None else min(left, split.most_per_campaign)
            violations += self._take(source, EventKind.COLLISION, name, split, most)
        # A search that gave less than its share leaves the rest to the others.
        successes: list[Case] = []
        while (left := split.successes - len(successes)) > 0:
            available = [len(source.of_outcome(EventKind.GOAL)) for source in sources]
            before = [len(source.taken) for source in sources]
            for source, share in zip(sources, shares(left, available), strict=True):
                successes += self._take(source, EventKind.GOAL, name, split, share)
            if before == [len(source.taken) for source in sources]:
                break
        self._note_shortage(family, name, "violations", len(violations), split.violations, len(sources))
        self._note_shortage(family, name, "successes", len(successes), split.successes, len(sources))

    def _note_shortage(self, family: str, split: str, kind: str, found: int, wanted: int, searches: int) -> None:
        if found < wanted:
            self.shortages.append(f"{family} {split}: {found} of {wanted} {kind} after {searches} searches")

    def _search(self, campaign: Campaign, place: str, budget: int) -> _Source | None:
        """Go on with a search to its budget; with a partial corpus, only read it, if nobody is at work there."""
        folder = self._folder / place
        if self._is_partial and not (folder / LEDGER).exists():
            return None
        try:
            with Ledger(folder, campaign.settings) as ledger:
                end = min(budget, len(ledger.entries)) if self._is_partial else budget
                stage = f"{place} {campaign.technique}"
                self._tell(stage, min(end, len(ledger.entries)), end)

                def report(entry: LedgerEntry) -> None:
                    self._tell(stage, entry.index + 1, end)

                run = partial(self._mapper, partial(evaluate, campaign.subject))
                return _Source(campaign, run_campaign(campaign, ledger, run, end, report))
        except InUseError:
            if self._is_partial:
                return None
            raise

    def _take(self, source: _Source, outcome: EventKind, split_name: str, split: SplitPlan, most: int) -> list[Case]:
        """Up to ``most`` cases of one outcome from one search, each confirmed by another run."""
        picker = source.pickers.setdefault(
            outcome, Picker(family_of(source.campaign.subject.family).space, split.least_distance, self._digests)
        )
        accepted: list[Case] = []
        while len(accepted) < most:
            picked = picker.pick(source.of_outcome(outcome), most - len(accepted))
            if not picked:
                break
            source.taken |= {index for index, _ in picked}
            cases = [_case(source.campaign, split_name, index, trial) for index, trial in picked]
            accepted += self._persistent(self._confirm(cases), split)
        return accepted

    def _confirm(self, candidates: Sequence[Case]) -> list[Case]:
        """Those that come to the same when they are run again from what the manifest will say of them."""
        stage = f"{candidates[0].family} {candidates[0].split}: run again"
        confirmed: list[Case] = []
        parsed = [Case.parse(case.dump()) for case in candidates]
        for number, (case, found) in enumerate(zip(parsed, self._rerunner(parsed), strict=True), 1):
            self._tell(stage, number, len(parsed))
            if agrees(found, case):
                confirmed.append(case)
            else:
                self.dropped += 1
        return confirmed

    def _persistent(self, candidates: Sequence[Case], split: SplitPlan) -> list[Case]:
        """Those that are no violation or a persistent one, with their persistence; they are the corpus's from now on."""
        if not candidates:
            return []
        stage = f"{candidates[0].family} {candidates[0].split}: persistence"
        taken: list[Case] = []
        for number, (case, found) in enumerate(
            zip(candidates, self._teller(candidates, split.futures), strict=True), 1
        ):
            self._tell(stage, number, len(candidates))
            if case.is_violation and split.futures:
                if found is None:
                    self.dropped += 1
                    continue
                if found < split.least_persistence:
                    self.fleeting += 1
                    continue
            taken.append(replace(case, persistence=found))
            self._digests.add(case.digest)
        self.cases += taken
        return taken

    def _tell(self, stage: str, done: int, total: int) -> None:
        self.report(Progress(stage, done, total, len(self.cases), self.wanted))


def _case(campaign: Campaign, split: str, index: int, trial: Trial) -> Case:
    subject, result = campaign.subject, trial.evaluation.result
    assert result is not None
    parameters = used_parameters(family_of(subject.family).build, trial.parameters, subject.seed)
    return Case(
        name=campaign.name(index),
        family=subject.family,
        split=split,
        seed=subject.seed,
        parameters=parameters,
        technique=campaign.technique,
        search_seed=subject.seed,
        index=index,
        **told_of(result),
    )


@dataclass(frozen=True, slots=True)
class Gathered:
    """A corpus and what it lacks."""

    corpus: Corpus
    shortages: tuple[str, ...]


def gather(
    plan: CorpusPlan,
    policy: str,
    families: Sequence[str],
    folder: Path,
    workers: int,
    report: Report = lambda _progress: None,
    *,
    command: str = "",
    is_partial: bool = False,
) -> Gathered:
    """Gather a corpus; what is in the folder already is not searched again.

    Deterministic: the plan, the policy and the families decide everything, whatever the number of workers and however
    often it is interrupted.

    Args:
        plan: what to gather.
        policy: who drives.
        families: of which scenarios.
        folder: of all searches; those of the policy are in POLICY/FAMILY/SPLIT-NUMBER below it.
        workers: processes.
        report: called as it goes on.
        command: noted in the corpus.
        is_partial: make do with what the searches that are there hold, and search nothing.

    Raises:
        InputError: there is no such policy or family, or a folder holds another search, is in use or cannot be written.
        SimulationError: a worker process died.
    """
    for family in families:
        FAMILY_REGISTRY.find_installed(family)  # for a corpus can be read with those alone
    own = folder / POLICY_REGISTRY.find(policy).label
    with (
        fan_out(workers) as mapper,
        Journal(own / RERUNS, RERUN_FORMAT) as reruns,
        Journal(own / PERSISTENCE, PERSISTENCE_FORMAT) as told,
    ):
        rerunner, teller = Rerunner(policy, mapper, reruns), PersistenceTeller(policy, mapper, told)
        gatherer = Gatherer(plan, policy, own, rerunner, teller, mapper, is_partial=is_partial)
        gatherer.gather(families, report)
    corpus = Corpus(
        policy,
        sorted_cases(gatherer.cases),
        policy_model(policy),
        command,
        plan.model_dump(mode="json"),
        gatherer.dropped,
        gatherer.fleeting,
    )
    return Gathered(corpus, tuple(gatherer.shortages))


def gather_fresh(
    policy: str,
    seed: int,
    cases: int,
    folder: Path,
    workers: int,
    report: Report = lambda _progress: None,
    *,
    families: Sequence[str] = tuple(FAMILIES),
) -> Gathered:
    """Gather a test set that no corpus of the project and no training has seen.

    Args:
        policy: who drives.
        seed: of the searches; another one gives other cases.
        cases: violations, and as many successes, of each family.
        folder: of all searches; those of the seed are in fresh-SEED/POLICY below it. A call that was interrupted goes on.
        workers: processes.
        report: called as it goes on.
        families: of which scenarios.

    Raises:
        InputError: as ``gather``, or the seed or the number of cases is out of range.
        SimulationError: a worker process died.
    """
    command = f"roadmend corpus build --policy {policy} --fresh-seed {seed} --cases {cases}"
    command += "".join(f" --family {name}" for name in families) if [*families] != [*FAMILIES] else ""
    return gather(fresh_plan(seed, cases), policy, families, folder / f"fresh-{seed}", workers, report, command=command)
