"""Gathers the frames of cases by letting the policy drive them alone, in worker processes, each case at most once."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import Tick
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer, TokenSet
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.runner import run_episode

_LAYOUT = 1  # of a file with frames; grows with every change


@dataclass(frozen=True, slots=True)
class Recipe:
    """What decides which frames a case gives."""

    policy: str
    policy_digest: str
    tokenizer: str  # name
    stride: int  # every so many-th tick is a frame, from the first on

    def key(self, case: EpisodeCase) -> str:
        """Name for a case's frames: cases or recipes that differ have different ones."""
        version = make_tokenizer(self.tokenizer).version
        parts = [_LAYOUT, self.policy, self.policy_digest, self.tokenizer, version, self.stride]
        text = json.dumps([*parts, case.name, case.digest])
        return hashlib.sha256(text.encode()).hexdigest()[:32]


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
    if case.digest and summary.digest != case.digest:
        mend = "verify the corpus, and build it again if the policy has changed since"
        raise InputError(f"case {case.name}", f"'{recipe.policy}' does not drive it as the corpus says", mend)
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
    gathered: list[CaseFrames] = []
    for case, path in zip(cases, mapper(partial(_keep, recipe=recipe, cache=cache), cases), strict=True):
        frames = CaseFrames.load(path)
        if frames.name != case.name:
            raise InputError(str(path), f"holds case {frames.name}, not {case.name}", "remove the file")
        gathered.append(frames)
        report(frames)
    return gathered


def _keep(case: EpisodeCase, *, recipe: Recipe, cache: Path) -> Path:
    path = cache / f"{recipe.key(case)}.npz"
    try:
        if path.exists():
            CaseFrames.load(path)
            return path
    except ValueError:
        pass  # a damaged file is made anew
    frames = frames_of_case(case, recipe)
    frames.save(path)
    return path
