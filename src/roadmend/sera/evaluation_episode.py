"""One episode of an evaluation set, driven in this process: its measures, and a bag where something went wrong."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, Self

from roadmend import __version__
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import RoadmendError, SimulationError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.answering import Answering
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.fitting import fitting
from roadmend.measures.measured_run import EpisodeObserver, measured_run
from roadmend.policies.registry import make_policy
from roadmend.recording.episode_recorder import EpisodeRecorder, account_of
from roadmend.recording.layout import RECORD
from roadmend.recording.new_bag import new_bag
from roadmend.recording.writer import BagWriter
from roadmend.repair.registry import make_repairer
from roadmend.world.network import network_file
from roadmend.world.road_network import lanes_of, read_network
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import dump_scenario, outside_content

_FORMAT = "roadmend-evaluated-episodes/2"
Record = Literal["failures", "all", "none"]


@dataclass(frozen=True, slots=True)
class EvaluationJob:
    """What to drive; travels to other processes by pickle."""

    scenario: Scenario
    policy: str  # name or model file
    method: str
    folder: Path  # of the bags
    record: Record  # failures: what does not end at the goal, or was repaired on the way
    driver: Key  # see ``measures.driver``

    @property
    def key(self) -> Key:
        """Of all that decides what comes out."""
        decided = self.scenario.digest, outside_content(self.scenario)
        return entry_key([__name__], *decided, self.record, Path(self.policy).stem, self.driver)


@dataclass(frozen=True, slots=True)
class EvaluatedEpisode:
    """What a job came to."""

    result: EpisodeResult | None = None
    measures: DrivingMeasures | None = None
    bag: str = ""  # name of the bag's folder; empty where none was written
    fault: str = ""  # why there is no result

    @classmethod
    def parse(cls, kept: Mapping[str, Any]) -> Self:
        """From plain values, as ``dataclasses.asdict`` and JSON give them."""
        return cls(EpisodeResult.parse(kept["result"]), DrivingMeasures.parse(kept["measures"]), kept["bag"])


def evaluate(job: EvaluationJob) -> EvaluatedEpisode:
    """Drive one scenario; whatever goes wrong is a result here."""
    try:
        return _evaluate(job)
    except RoadmendError as error:
        return EvaluatedEpisode(fault=f"{job.scenario.name}: {error}")
    except Exception as error:  # noqa: BLE001 - the others shall go on, and this one is reported
        return EvaluatedEpisode(fault=" ".join(f"{job.scenario.name}: {type(error).__name__}: {error}".split()))


def _evaluate(job: EvaluationJob) -> EvaluatedEpisode:
    result, measures = _drive(job)
    failed = not result.reached_goal or result.interventions > 0
    if job.record == "none" or (job.record == "failures" and not failed):
        return EvaluatedEpisode(result, measures)
    # Recording slows a run down, and most need none: those that do are driven again, which gives the same.
    bag = job.folder / f"{job.scenario.name}-{Path(job.policy).stem}-{job.method}-{job.key[:8]}"
    if not bag.exists():  # else of an earlier call with the same key: what is there is whole
        with new_bag(bag) as writer:
            if _record(job, writer).digest != result.digest:
                raise SimulationError("the run that was recorded differs from the one before")
    return EvaluatedEpisode(result, measures, bag.name)


def _drive(job: EvaluationJob, *observers: EpisodeObserver) -> tuple[EpisodeResult, DrivingMeasures]:
    repairer = Answering(make_repairer(job.method, fitting(job.method, job.policy)))
    return measured_run(job.scenario, make_policy(job.policy), repairer, *observers)


def _record(job: EvaluationJob, writer: BagWriter) -> EpisodeResult:
    file = f"{job.scenario.name}.yaml"
    writer.add_attachment(file, "application/yaml", dump_scenario(job.scenario).encode())
    network = read_network(network_file(job.scenario.network))
    result, _ = _drive(job, EpisodeRecorder(writer, lambda _: job.method, lanes_of(network)))
    account = {"scenario_file": file, "policy": job.policy, "method": job.method, "seed": "0", "roadmend": __version__}
    writer.add_metadata(RECORD, account | account_of(result, writer.count))
    return result


def drive_jobs(
    jobs: Sequence[EvaluationJob], out: Path, workers: int, told: Callable[[int, int], None]
) -> list[EvaluatedEpisode]:
    """What each job came to, in order; what is there from an earlier call is not driven again.

    Args:
        jobs: to do.
        out: folder of what was done.
        workers: processes.
        told: hears how many are done, of how many.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        SimulationError: a worker process died.
    """
    with Journal(out / "results.jsonl", _FORMAT, owns_folder=True) as journal:
        done = {job.key: EvaluatedEpisode.parse(kept) for job in jobs if (kept := journal.get(job.key)) is not None}
        missing = [job for job in jobs if job.key not in done]
        before = len(jobs) - len(missing)
        told(before, len(jobs))
        with fan_out(workers, len(missing)) as mapper:
            for number, (job, episode) in enumerate(zip(missing, mapper(evaluate, missing), strict=True), before + 1):
                done[job.key] = episode
                if not episode.fault:
                    journal.add(job.key, asdict(episode))
                told(number, len(jobs))
    return [done[job.key] for job in jobs]
