"""What a method's braking does without its timing, in other futures, and what who knows the case would have done."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from statistics import fmean

from harness.grid import Setting
from harness.pulse import Pulse, PulsePlayer
from harness.shuffle import BlockPlayer, blocks_of, shuffled
from roadmend.core.fanout import Mapper
from roadmend.core.interfaces import Repairer
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.core.outcome import EventKind
from roadmend.core.tick import INTERVAL
from roadmend.measures.answering import Answering
from roadmend.measures.driver import driver_key
from roadmend.measures.evaluation import seed_of
from roadmend.measures.need import HORIZON
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import Case
from roadmend.world.futures import Future, futures, moment_at
from roadmend.world.runner import run_episode
from roadmend.world.simulation import Simulation

FORMAT = "roadmend-controls-work/1"
SHUFFLES = 3  # of a violation's blocks; a success's are shuffled once
FUTURES = 5  # of a violation in which a method is tried, and those by which an informed pulse is chosen
TESTED = 10  # further futures in which that pulse is tried
_STARTS = (2.5, 3.5, 1.5, 5.0)  # [s] before the impact
_PULSES = ((0.3, -1.0), (0.6, -1.0), (0.6, -0.4), (1.0, -1.0), (1.5, -1.0), (2.5, -1.0))  # [s], action


@dataclass(frozen=True, slots=True)
class ControlJob:
    """One case under one setting; under none of them it is the informed bound that is looked for."""

    case: Case
    policy: str
    setting: Setting | None

    @property
    def key(self) -> Key:
        """Of all that decides what comes out."""
        setting = self.setting
        driver = (
            driver_key(self.policy) if setting is None else driver_key(self.policy, setting.method, setting.parameters)
        )
        case = self.case
        told = (case.is_violation, case.duration, case.impact_speed)  # a corpus that was renewed may say otherwise
        return entry_key([__name__], case.name, case.scenario().digest, told, driver, setting is None)


@dataclass(frozen=True, slots=True)
class ControlResult:
    """What a case came to; shares 0 .. 1."""

    case: str
    family: str
    is_violation: bool
    impact_speed: float | None  # [m/s] of the policy alone
    worth: float  # 1: a violation ends at the goal, or a success collides; 0 else
    shuffled: float  # the same, mean over the shuffles
    dose: float  # [s]
    shuffled_dose: float  # [s] mean over the shuffles
    in_futures: float | None = None  # of a violation: share of its futures that the method brings to the goal
    bound: float | None = None  # informed bound: dose [s] of the least pulse; None where none was found
    bound_in_futures: float | None = None  # share of further futures that it brings to the goal


def run_controls(jobs: Sequence[ControlJob], journal: Journal, mapper: Mapper) -> Iterator[ControlResult]:
    """Do what the journal does not hold yet; results in the order of the jobs.

    Raises:
        InputError: the journal cannot be written.
        SimulationError: a worker process died, or SUMO failed.
        RoadmendError: a method could not answer.
    """
    known = [journal.get(job.key) for job in jobs]
    fresh = mapper(control, [job for job, kept in zip(jobs, known, strict=True) if kept is None])
    for job, kept in zip(jobs, known, strict=True):
        if kept is None:
            result = next(fresh)
            journal.add(job.key, asdict(result))
            yield result
        else:
            yield ControlResult(**kept)


def control(job: ControlJob) -> ControlResult:
    """Do one job in this process.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
        RoadmendError: the method could not answer, so that the guard's rule did.
    """
    return _informed(job) if job.setting is None else _shuffled(job, job.setting)


def _shuffled(job: ControlJob, setting: Setting) -> ControlResult:
    case, scenario = job.case, job.case.scenario()

    def method() -> Repairer:
        return Answering(make_repairer(setting.method, setting.parameters, seed_of(case.name)))

    result, blocks, waits = blocks_of(scenario, make_policy(job.policy), method())
    wanted = EventKind.GOAL if case.is_violation else EventKind.COLLISION
    until = round(case.duration / INTERVAL)
    found = []
    for number in range(SHUFFLES if case.is_violation else 1):
        seed = f"{case.name}:{number}"
        player = BlockPlayer(shuffled(blocks, until, seed), waits.player(seed))
        found.append(run_episode(scenario, make_policy(job.policy), player))
    share = None
    if case.is_violation:
        tried = _futures(case, job.policy, HORIZON, method(), range(1, FUTURES + 1))
        share = _arrived(tried)
    return ControlResult(
        case.name,
        case.family,
        case.is_violation,
        case.impact_speed,
        float(result.outcome is wanted),
        fmean(each.outcome is wanted for each in found),
        result.dose,
        fmean(each.dose for each in found),
        share,
    )


def _informed(job: ControlJob) -> ControlResult:
    """The least of a few pulses that brings all futures by which it is chosen to the goal, and the same in others.

    They are tried in the order of what they cost a policy at full throttle; the dose that is told is the case's own.
    """
    case = job.case
    for _, start, ticks, action in sorted(
        ((1.0 - action) * duration, start, round(duration / INTERVAL), action)
        for duration, action in _PULSES
        for start in _STARTS
    ):
        if start > case.duration:
            continue
        player = PulsePlayer((Pulse(0, ticks, action),))
        if _arrived(_futures(case, job.policy, start, player, range(1, FUTURES + 1))) == 1.0:
            tested = range(FUTURES + 1, FUTURES + TESTED + 1)
            share = _arrived(_futures(case, job.policy, start, player, tested))
            played = PulsePlayer((Pulse(_begin(case, start), ticks, action),))
            return _bound(case, run_episode(case.scenario(), make_policy(job.policy), played).dose, share)
    return _bound(case, None, None)


def _bound(case: Case, dose: float | None, share: float | None) -> ControlResult:
    return ControlResult(
        case.name,
        case.family,
        case.is_violation,
        case.impact_speed,
        float(dose is not None),
        0.0,
        dose or 0.0,
        0.0,
        bound=dose,
        bound_in_futures=share,
    )


def _begin(case: Case, before: float) -> int:
    """The tick so many seconds before the end of a case."""
    return max(0, round((case.duration - before) / INTERVAL))


def _futures(case: Case, policy_name: str, before: float, repairer: Repairer, seeds: range) -> list[Future]:
    """Futures, to the end of the episode, of the moment so long before the violation, a method at work from then on."""
    scenario = case.scenario()
    with Simulation(scenario) as simulation:
        moment = moment_at(simulation, make_policy(policy_name), make_repairer("none"), _begin(case, before))
        repairer.reset(simulation.route)
        return futures(moment, repairer, seeds, scenario.time_limit)


def _arrived(found: Sequence[Future]) -> float:
    return sum(future.final is not None and future.final.kind is EventKind.GOAL for future in found) / len(found)
