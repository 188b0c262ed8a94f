"""What risk monitors learn of: ticks of the drives of a case, and whether they ended badly. On disk as one .npz file."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import ArrayRecord
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.fanout import Mapper
from roadmend.core.journal import entry_key, file_of
from roadmend.repair.adreft.tokenizer import TokenSet
from roadmend.training.adreft.gathering import Recipe, gather_files
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.simulation import Simulation
from roadmend.world.variation import Spread


@dataclass(frozen=True, slots=True, eq=False)
class CaseRisks(ArrayRecord):
    """F ticks of the drives of one case, with M tokens of c attributes in all."""

    name: str  # of the case
    counts: NDArray[np.int32]  # tokens of each tick, shape (F,)
    tokens: NDArray[np.float16]  # shape (M, c); half precision is finer than what they measure
    collided: NDArray[np.float32]  # 1 where the ego collided by its own fault within the horizon, else 0, shape (F,)

    def __len__(self) -> int:
        return len(self.counts)

    @classmethod
    def of(cls, name: str, found: Sequence[tuple[TokenSet, bool]], attributes: int) -> Self:
        """Ticks with what came of them.

        Args:
            name: of the case.
            found: tokens of a tick, and whether it ended badly.
            attributes: c.
        """
        return cls(
            name,
            np.array([len(tokens) for tokens, _ in found], dtype=np.int32),
            np.concatenate([np.empty((0, attributes)), *(tokens.values for tokens, _ in found)]).astype(np.float16),
            np.array([collided for _, collided in found], dtype=np.float32),
        )


@dataclass(frozen=True, slots=True)
class RiskPlan:
    """How a case is driven."""

    model: str  # name or file of the model of ADReFT in question; its digest is part of what is kept
    digest: str  # of that model
    drives: int  # of a case that a search has found: the first as it is, the others in worlds that differ
    horizon: float  # [s]
    plain: bool  # ordinary driving, by which a monitor is judged
    history: bool  # whether tokens tell of the last second and the drive so far, too
    seed: int


class RiskDrive(Protocol):
    """Finds the ticks of a case; what is kept depends on the code of its module."""

    def __call__(self, case: EpisodeCase, recipe: Recipe, plan: RiskPlan) -> CaseRisks:
        """Drive it in this process.

        Raises:
            InputError: the scenario or the model is unusable.
            SimulationError: SUMO failed.
        """


def worlds_of(case: EpisodeCase, plan: RiskPlan) -> Iterator[tuple[int, Simulation]]:
    """The worlds in which a case is driven, with their numbers: 0 as it is, the others varied; one of a case undriven yet.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    for number in range(plan.drives if case.digest else 1):
        with Simulation(case.scenario()) as simulation:
            if number:
                simulation.vary(number, Spread())
            yield number, simulation


def ended_badly(result: EpisodeResult, time: float, horizon: float) -> bool:
    """Whether a drive ended in a collision of the ego's own fault within ``horizon`` [s] after ``time`` [s]."""
    return result.final.at_fault and result.duration - time <= horizon


def gather_risks(
    drive_case: RiskDrive,
    cases: Sequence[EpisodeCase],
    recipe: Recipe,
    plan: RiskPlan,
    cache: Path,
    mapper: Mapper,
    report: Callable[[CaseRisks], None] = lambda _risks: None,
) -> list[CaseRisks]:
    """Ticks of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        drive_case: finds those of a case.
        cases: what to drive.
        recipe: policy and tokenizer.
        plan: how.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its ticks are there.

    Raises:
        InputError: a case cannot be driven, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    keyed = asdict(replace(plan, model=""))  # its digest tells it
    keys = [entry_key([drive_case.__module__], key, keyed) for key in recipe.keys(cases)]
    places = [(case, file_of(cache, key, ".npz")) for case, key in zip(cases, keys, strict=True)]
    return gather_files(places, partial(drive_case, recipe=recipe, plan=plan), CaseRisks, mapper, report)
