"""Who is measured on what: corpora, contenders and the hindsight bound, brought together for the benchmark."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.progress import Progress

from harness.benchmark_run import HINDSIGHT, Player, PolicyBenchmark
from harness.contenders import Absence, BenchmarkPlan, resolve, resolve_monitors
from harness.fresh_cases import fresh_cases
from harness.hindsight import Bound
from harness.hindsight_file import hindsight_bound
from harness.pulse import PulsePlayer
from roadmend.core.errors import InputError
from roadmend.search.policy_model import policy_model
from roadmend.world.corpus import Case, Corpus, corpus_of

LUCKY = "hindsight_lucky"


@dataclass(frozen=True)
class Choice:
    """What is to be measured."""

    policies: tuple[str, ...]
    methods: tuple[str, ...]
    families: tuple[str, ...]
    cases: int | None  # violations, and successes, of each family; None: all
    split: str  # of the corpora
    fresh_seed: int | None
    corpora: Path
    is_quick: bool

    @property
    def settings(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "policies": [*self.policies],
            "methods": [*self.methods],
            "families": [*self.families],
            "cases": self.cases,
            "split": self.split,
            "fresh_seed": self.fresh_seed,
            "quick": self.is_quick,
        }


def find_benchmarks(
    plan: BenchmarkPlan, config: Path, choice: Choice, work: Path, workers: int, progress: Progress
) -> list[PolicyBenchmark]:
    """Load or gather the cases of every policy, and see which methods can run.

    Raises:
        InputError: a corpus or a parameter is unusable.
        SimulationError: a worker process died.
    """
    return [_benchmark(plan, config, choice, policy, work, workers, progress) for policy in choice.policies]


def _benchmark(
    plan: BenchmarkPlan, config: Path, choice: Choice, policy: str, work: Path, workers: int, progress: Progress
) -> PolicyBenchmark:
    contenders, absences = resolve(plan, config, policy, [*choice.methods])
    if not contenders:
        return PolicyBenchmark(policy, "", "", (), (), (), tuple(absences))
    if choice.fresh_seed is None:
        path = choice.corpora / f"{policy}.jsonl"
        if not path.is_file():
            reason = f"there is no corpus {path.name}"
            return PolicyBenchmark(
                policy, "", "", (), (), (), tuple(Absence(name, policy, reason) for name in choice.methods)
            )
        corpus = corpus_of(policy, path)
    else:
        assert choice.cases is not None
        corpus = fresh_cases(policy, choice.fresh_seed, choice.cases, work, workers, progress, choice.families)
    model = policy_model(policy)
    if corpus.model != model:
        what = "was gathered with another model of the policy"
        raise InputError(f"corpus of {policy}", what, "build it again with 'roadmend corpus build'")
    cases = select(corpus, choice.families, choice.cases, choice.split)
    if not cases:
        raise InputError(
            f"corpus of {policy}", f"holds no {choice.split} cases of what was asked for", "ask for other families"
        )
    names = plan.quick.monitors if choice.is_quick else plan.monitors
    monitors = resolve_monitors(plan, config, policy, names)
    players: dict[str, dict[str, Player]] = {}
    if any(contender.group == "bound" for contender in contenders):
        bounds = _bounds(cases, policy, work, workers, progress)
        players = {
            HINDSIGHT: {case.name: _player(bounds.get(case.name), is_lucky=False) for case in cases},
            LUCKY: {case.name: _player(bounds.get(case.name), is_lucky=True) for case in cases},
        }
    return PolicyBenchmark(
        policy, model or "", corpus.digest, tuple(cases), tuple(contenders), tuple(monitors), tuple(absences), players
    )


def _player(bound: Bound | None, *, is_lucky: bool) -> Player:
    """The profile that was found for a case, one that may begin a little earlier or later if there is one."""
    profile = None
    if bound is not None:
        profile = bound.lucky if is_lucky else bound.best or bound.lucky
    text = json.dumps(asdict(profile.pulse) if profile is not None else None, sort_keys=True)
    pulses = (profile.pulse,) if profile is not None else ()
    return Player(PulsePlayer(pulses), hashlib.sha256(text.encode()).hexdigest())


def select(corpus: Corpus, families: Sequence[str], most: int | None, split: str) -> list[Case]:
    """The cases of some families in a split, at most ``most`` violations and as many successes of each."""
    return [
        case
        for family in families
        for violation in (True, False)
        for case in corpus.select(family, split, violation=violation)[:most]
    ]


def _bounds(cases: Sequence[Case], policy: str, work: Path, workers: int, progress: Progress) -> dict[str, Bound]:
    """By case."""
    violations = [case for case in cases if case.is_violation]
    task = progress.add_task(f"{policy}: hindsight bound", total=len(violations))
    found = hindsight_bound(violations, policy, workers, work / "hindsight", lambda _bound: progress.advance(task))
    return {bound.name: bound for bound in found}
