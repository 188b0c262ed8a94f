"""Gathers the frames of cases by letting the policy drive them alone, in worker processes, each case at most once."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol, Self, TypeVar

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.fanout import Mapper
from roadmend.core.journal import Key, entry_key, file_of
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import Tick
from roadmend.measures.driver import driver_key
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer, TokenSet
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.closed_loop import EpisodeCase, check_driven
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import outside_content


class CaseFile(Protocol):
    """What is gathered of a case; kept as a file."""

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all.

        Raises:
            InputError: the place cannot be written.
        """

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file.

        Raises:
            OSError: there is no such file.
            ValueError: it is damaged.
        """


Gathered = TypeVar("Gathered", bound=CaseFile)


def gather_files(
    places: Sequence[tuple[EpisodeCase, Path]],
    gather: Callable[[EpisodeCase], Gathered],
    kind: type[Gathered],
    mapper: Mapper,
    report: Callable[[Gathered], None],
) -> list[Gathered]:
    """What is gathered of cases, in their order; what is there is not driven again.

    Args:
        places: cases with the files of what is gathered of them; an interruption costs the cases under way only.
        gather: drives one case.
        kind: what it gives.
        mapper: runs cases side by side.
        report: called for every case as soon as its file is there.

    Raises:
        InputError: a case cannot be driven or is not driven as the corpus says, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    gathered: list[Gathered] = []
    done = mapper(partial(_keep, gather=gather, kind=kind), places)
    for _, (_, path) in zip(done, places, strict=True):
        gathered.append(kind.load(path))
        report(gathered[-1])
    return gathered


def _keep(place: tuple[EpisodeCase, Path], *, gather: Callable[[EpisodeCase], CaseFile], kind: type[CaseFile]) -> None:
    case, path = place
    with suppress(FileNotFoundError, ValueError):  # a damaged file is made anew
        kind.load(path)
        return
    gather(case).save(path)


@dataclass(frozen=True, slots=True)
class Recipe:
    """What decides which frames a case gives."""

    policy: str
    tokenizer: str  # name
    stride: int  # every so many-th tick is a frame, from the first on

    def keys(self, cases: Sequence[EpisodeCase]) -> list[Key]:
        """Of the frames of cases."""
        version, driver = make_tokenizer(self.tokenizer).version, driver_key(self.policy)
        recipe = driver, self.tokenizer, version, self.stride
        return [entry_key([__name__], *recipe, case.name, case.digest, *_world_of(case.scenario())) for case in cases]


def _world_of(scenario: Scenario) -> tuple[str, str | None]:
    return scenario.digest, outside_content(scenario)


class _Recorder:
    """A repairer that repairs nothing and keeps every ``stride``-th tick. The tokenizer sees all: it may remember."""

    name = "none"

    def __init__(self, tokenizer: Tokenizer, stride: int) -> None:
        self._tokenizer, self._stride = tokenizer, stride
        self._repairer = make_repairer("none")
        self._tokens: TokenSet | None = None
        self.time: list[float] = []
        self.action: list[float] = []
        self.distance: list[float] = []
        self.tokens: list[TokenSet] = []

    def reset(self, route: Route) -> None:
        """Begin an episode."""
        self._repairer.reset(route)
        self._tokenizer.reset(route)

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Let the decision pass."""
        self._tokens = self._tokenizer.tokens(scene, decision)
        return self._repairer.step(scene, decision)

    def watch(self, tick: Tick, decision: Decision, _repair: Repair) -> None:
        """Keep the tick that was just answered, if it is its turn."""
        if tick.number % self._stride == 0 and self._tokens is not None:
            self.time.append(tick.scene.time)
            self.action.append(decision.command.action)
            self.distance.append(tick.min_distance)
            self.tokens.append(self._tokens)


def frames_of_case(case: EpisodeCase, recipe: Recipe) -> CaseFrames:
    """Drive one case without repair in this process.

    Raises:
        InputError: the scenario is unusable, or the policy drives it otherwise than the corpus says.
        SimulationError: SUMO failed.
    """
    recorder = _Recorder(make_tokenizer(recipe.tokenizer), recipe.stride)
    summary = run_episode(case.scenario(), make_policy(recipe.policy), recorder, recorder.watch)
    check_driven(case, recipe.policy, summary.digest)
    return CaseFrames(
        case.name,
        case.family,
        summary.outcome.name,
        summary.duration,
        np.array(recorder.time),
        np.array(recorder.action, dtype=np.float32),
        np.array(recorder.distance),
        np.array([len(tokens) for tokens in recorder.tokens], dtype=np.int32),
        np.concatenate([tokens.values for tokens in recorder.tokens]),
    )


def gather_frames(
    cases: Sequence[EpisodeCase],
    recipe: Recipe,
    cache: Path,
    mapper: Mapper,
    report: Callable[[CaseFrames], None] = lambda _frames: None,
) -> list[CaseFrames]:
    """Frames of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        cases: what to drive.
        recipe: how, and what to keep.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its frames are there.

    Raises:
        InputError: a case cannot be driven or is not driven as the corpus says, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    places = [(case, file_of(cache, key, ".npz")) for case, key in zip(cases, recipe.keys(cases), strict=True)]
    return gather_files(places, partial(frames_of_case, recipe=recipe), CaseFrames, mapper, report)
