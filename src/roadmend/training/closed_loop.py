"""How a repair method fares on cases of a corpus: every case driven to its end in closed loop, and the sum of it."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, Protocol

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper, fan_out
from roadmend.measures.answering import Answering
from roadmend.measures.case_result import CaseResult
from roadmend.measures.repair import delta_e, figures_of
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario


class EpisodeCase(Protocol):
    """What is needed of a case of a corpus (``world.corpus.Case``)."""

    @property
    def name(self) -> str:
        """Name of the scenario."""

    @property
    def family(self) -> str:
        """Name of the scenario's family."""

    @property
    def digest(self) -> str:
        """Digest of the trajectory that the policy alone drives."""

    @property
    def is_violation(self) -> bool:
        """Whether the policy alone collides."""

    def scenario(self) -> Scenario:
        """The scenario itself."""


def check_driven(case: EpisodeCase, policy: str, digest: str) -> None:
    """Refuse a case that a policy alone drives otherwise than its corpus says.

    Args:
        case: one without a digest may be driven in any way.
        policy: its name.
        digest: of the trajectory that it has driven.

    Raises:
        InputError: it is another one.
    """
    if case.digest and digest != case.digest:
        mend = "verify the corpus, and build it again if the policy has changed since"
        raise InputError(f"case {case.name}", f"'{policy}' does not drive it as the corpus says", mend)


@dataclass(frozen=True, slots=True)
class Summary:
    """Figures of a method over cases; shares in per cent, 0 where there is no case to count."""

    violations: int
    successes: int
    fix: float  # [%] of the violations that now reach their goal
    fix_loose: float  # [%] of the violations that no longer collide (the paper's count)
    deg: float  # [%] of the successes that now collide
    late: float  # [%] of the successes that now neither collide nor reach their goal
    delta_e: float  # [%] fix - deg
    delta_e_loose: float  # [%] fix_loose - deg
    intensity: float  # mean |policy action - final action| over all frames that were replaced, 0 .. 2
    dose: float  # [s] mean over the violations
    dose_success: float  # [s] mean over the successes
    intervened_frames: float  # [%] of all frames

    def as_dict(self) -> dict[str, float]:
        """Plain values by name."""
        return asdict(self)


def evaluate_cases(
    cases: Sequence[EpisodeCase],
    policy: str,
    method: str,
    parameters: Mapping[str, Any] | None = None,
    workers: int = 1,
    *,
    mapper: Mapper | None = None,
    report: Callable[[CaseResult], None] = lambda _result: None,
) -> list[CaseResult]:
    """Drive every case with a policy under a repair method; one result a case, in the order of the cases.

    Args:
        cases: what to drive.
        policy: name of the policy.
        method: name of the repair method.
        parameters: what differs from the method's defaults.
        workers: processes; the results do not depend on their number.
        mapper: processes that are open already, instead of ``workers`` new ones.
        report: called with every result as soon as it is there.

    Raises:
        InputError: there is no such policy or method, a parameter or a scenario is unusable.
        SimulationError: SUMO failed, or a worker process died.
        RoadmendError: the method could not answer, so that the guard's rule did.
    """
    make_policy(policy)
    make_repairer(method, parameters)  # a fault in what was given is said before the first process starts
    work = partial(_evaluate, policy=policy, method=method, parameters=dict(parameters or {}))
    results: list[CaseResult] = []
    with nullcontext(mapper) if mapper is not None else fan_out(workers, len(cases)) as chosen:
        for result in chosen(work, cases):
            results.append(result)
            report(result)
    return results


def _evaluate(case: EpisodeCase, *, policy: str, method: str, parameters: Mapping[str, Any]) -> CaseResult:
    episode = run_episode(case.scenario(), make_policy(policy), Answering(make_repairer(method, parameters)))
    return CaseResult(case.name, case.family, case.is_violation, episode)


def summarise(results: Sequence[CaseResult]) -> Summary:
    """Sum up results."""
    known = figures_of(results)
    figures = {name: value or 0.0 for name, value in known.items()}
    ticks = sum(result.episode.ticks for result in results)
    frames = sum(result.episode.interventions for result in results)
    successes = [result.episode for result in results if not result.is_violation]
    late = sum(not (episode.reached_goal or episode.collided) for episode in successes)
    return Summary(
        violations=known["violations"],
        successes=known["successes"],
        fix=figures["fix"],
        fix_loose=figures["fix_loose"],
        deg=figures["deg"],
        late=100.0 * late / len(successes) if successes else 0.0,
        delta_e=delta_e(figures["fix"], figures["deg"]),
        delta_e_loose=delta_e(figures["fix_loose"], figures["deg"]),
        intensity=figures["intensity"],
        dose=figures["dose_violations"],
        dose_success=figures["dose_successes"],
        intervened_frames=100.0 * frames / ticks if ticks else 0.0,
    )
