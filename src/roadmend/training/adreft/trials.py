"""Trials: episodes in which the policy is interfered with at random, to learn what an intervention is worth.

The paper explores tick by tick (ADReFT algorithm 1); a tick of braking changes nothing that could be learned from. A
trial holds an action for a while, as an intervention does, and it begins where it may matter: in the seconds before
the collision that the policy alone would have. Collisions of other kinds than a search finds come from successes that
the policy drives without seeing everybody.
"""

import hashlib
import json
import os
import random
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.policies.registry import make_policy
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer
from roadmend.training.adreft.blinding import BlindedPolicy, Blindness, draw_blindness
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.closed_loop import EpisodeCase
from roadmend.training.workers import Mapper
from roadmend.world.runner import EpisodeSummary, run_episode
from roadmend.world.simulation import INTERVAL, Tick

PASS = -1  # in the place of an action: the policy's own
_LAYOUT = 3  # of a file with trials; grows with every change
_LATEST, _EARLIEST = 0.3, 6.0  # [s] before the collision, between which the first intervention of a trial begins
_SHORTEST, _LONGEST = 0.2, 4.0  # [s] of an action held
_USUAL = 0.8  # [s] mean of what is held beyond the shortest
_PAUSE = 2.0  # [s] longest pause between two interventions of a trial
_NUMBERS = (1, 1, 2, 3)  # of interventions in a trial, each as likely
_LEAD = 0.2  # [s] before the first intervention from which a trial is kept: before that it is the episode untouched


@dataclass(frozen=True, slots=True)
class Hold:
    """An action that is held for a while."""

    begin: float  # [s] simulation time
    end: float  # [s]
    action: int  # index into ACTIONS


@dataclass(frozen=True, slots=True)
class TrialPlan:
    """How many trials a case gets. The first episode is always the policy alone."""

    per_violation: int
    per_success: int
    blinded: (
        int  # times that a success is driven with the policy blinded; where that collides, per_violation trials more
    )
    interval: int  # ticks between two decisions
    seed: int

    def key(self, case: EpisodeCase, recipe: Recipe) -> str:
        """Name for a case's trials: cases or plans that differ have different ones."""
        text = json.dumps([_LAYOUT, recipe.key(case), *asdict(self).values()])
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def holds(self, name: str, number: int, end: float, *, collides: bool) -> list[Hold]:
        """The interventions of one trial, drawn from the seed, the name and the trial's number.

        Args:
            name: of what is driven.
            number: of the trial, from 1.
            end: when the policy alone collides or ends the case [s].
            collides: which of the two.
        """
        chance = random.Random(f"{self.seed}:{name}:{number}")
        if collides:
            begin = max(0.0, end - chance.uniform(_LATEST, _EARLIEST))
        else:
            begin = chance.uniform(0.0, max(0.0, end - 1.0))
        planned = []
        for _ in range(chance.choice(_NUMBERS)):
            duration = min(_LONGEST, _SHORTEST + chance.expovariate(1.0 / _USUAL))
            planned.append(Hold(begin, begin + duration, chance.randrange(1, len(ACTIONS))))
            begin += duration + chance.choice((0.0, 0.0, chance.uniform(0.0, _PAUSE)))
        return planned


@dataclass(frozen=True, slots=True, eq=False)
class CaseTrials:
    """T episodes of one case with F decisions and M tokens of c attributes in all. On disk as one .npz file."""

    name: str  # of the case
    outcomes: NDArray[np.int8]  # EventKind of each episode, shape (T,)
    ends: NDArray[np.float64]  # [s] of each episode, shape (T,)
    lengths: NDArray[np.int32]  # decisions of each episode, shape (T,)
    time: NDArray[np.float64]  # [s] of each decision, shape (F,)
    action: NDArray[np.float32]  # the policy's throttle - brake, shape (F,)
    choice: NDArray[np.int8]  # index into ACTIONS of what was held, PASS for the policy's own, shape (F,)
    dose: NDArray[np.float32]  # [s] until the next decision, shape (F,)
    distance: NDArray[np.float32]  # [m] least until the next decision, inf where nobody was there, shape (F,)
    counts: NDArray[np.int32]  # tokens of each decision, shape (F,)
    tokens: NDArray[np.float16]  # shape (M, c); half precision is finer than what they measure

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all.

        Raises:
            OSError: the place cannot be written.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f".{path.name}.{os.getpid()}")
        with beside.open("wb") as file:
            content: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
            np.savez(file, allow_pickle=False, **content)
        beside.replace(path)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file.

        Raises:
            OSError: there is no such file.
            ValueError: it is damaged.
        """
        try:
            with np.load(path, allow_pickle=False) as content:
                arrays: dict[str, Any] = {key.name: content[key.name] for key in fields(cls) if key.name != "name"}
                return cls(str(content["name"]), **arrays)
        except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise ValueError(f"{path} is damaged: {error!r}") from None


class _Trial:
    """A repairer that plays its holds and keeps a decision every ``interval`` ticks from ``since`` [s] on."""

    name = "trial"

    def __init__(self, tokenizer: Tokenizer, holds: Sequence[Hold], interval: int) -> None:
        self._tokenizer, self._holds, self._interval = tokenizer, holds, interval
        self._since = min((hold.begin for hold in holds), default=0.0) - _LEAD
        self._tick = 0
        self._choice = PASS
        self.time: list[float] = []
        self.action: list[float] = []
        self.choice: list[int] = []
        self.dose: list[float] = []
        self.distance: list[float] = []
        self.tokens: list[NDArray[np.float16]] = []

    def reset(self, route: Route) -> None:
        """Begin an episode."""
        self._tokenizer.reset(route)

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick."""
        tokens = self._tokenizer.tokens(scene, decision)  # at every tick: it may remember
        command = decision.command
        asked = command.action
        if self._tick % self._interval == 0:
            now = scene.time
            self._choice = next((hold.action for hold in self._holds if hold.begin <= now < hold.end), PASS)
            if now >= self._since:
                self.time.append(now)
                self.action.append(asked)
                self.choice.append(self._choice)
                self.dose.append(0.0)
                self.distance.append(np.inf)
                self.tokens.append(tokens.values.astype(np.float16))
        self._tick += 1
        wanted = asked if self._choice == PASS else ACTIONS[self._choice]
        if wanted >= asked:
            return Repair(command, RepairStatus.PASS, 0.0, 0.5, asked, wanted, intervened=False)
        final = Command.from_action(wanted, change_lane=command.change_lane)
        return Repair(final, RepairStatus.REPAIRED, 1.0, 0.5, asked, wanted, intervened=True)

    def watch(self, tick: Tick, _decision: Decision, repair: Repair) -> None:
        """Credit the tick that was just answered to the last decision."""
        if self.time:
            self.dose[-1] += (repair.policy_action - repair.final_action) * INTERVAL
            self.distance[-1] = min(self.distance[-1], tick.min_distance)


def try_case(case: EpisodeCase, recipe: Recipe, plan: TrialPlan) -> CaseTrials:
    """Drive all trials of one case in this process.

    Raises:
        InputError: the scenario is unusable, or the policy drives it otherwise than the corpus says.
        SimulationError: SUMO failed.
    """
    driven: list[tuple[_Trial, EpisodeSummary]] = []

    def drive(holds: Sequence[Hold], blindness: Blindness | None = None) -> EpisodeSummary:
        trial = _Trial(make_tokenizer(recipe.tokenizer), holds, plan.interval)
        policy = make_policy(recipe.policy)
        driver = policy if blindness is None else BlindedPolicy(policy, blindness)
        summary = run_episode(case.scenario(), driver, trial, trial.watch)
        if trial.time:
            driven.append((trial, summary))
        return summary

    alone = drive(())
    if case.digest and alone.digest != case.digest:
        mend = "verify the corpus, and build it again if the policy has changed since"
        raise InputError(f"case {case.name}", f"'{recipe.policy}' does not drive it as the corpus says", mend)
    collides = alone.outcome == EventKind.COLLISION
    for number in range(1, 1 + (plan.per_violation if collides else plan.per_success)):
        drive(plan.holds(case.name, number, alone.duration, collides=collides))
    for index in range(0 if collides else plan.blinded):
        name = f"{case.name}:blinded-{index}"
        blindness = draw_blindness(f"{plan.seed}:{name}", alone.duration)
        first = drive((), blindness)
        for number in range(1, 1 + (plan.per_violation if first.outcome == EventKind.COLLISION else 0)):
            drive(plan.holds(name, number, first.duration, collides=True), blindness)
    trials = [trial for trial, _ in driven]
    tokens = [tokens for trial in trials for tokens in trial.tokens]
    return CaseTrials(
        case.name,
        np.array([int(summary.outcome) for _, summary in driven], dtype=np.int8),
        np.array([summary.duration for _, summary in driven]),
        np.array([len(trial.time) for trial in trials], dtype=np.int32),
        np.array([time for trial in trials for time in trial.time]),
        np.array([action for trial in trials for action in trial.action], dtype=np.float32),
        np.array([choice for trial in trials for choice in trial.choice], dtype=np.int8),
        np.array([dose for trial in trials for dose in trial.dose], dtype=np.float32),
        np.array([distance for trial in trials for distance in trial.distance], dtype=np.float32),
        np.array([len(one) for one in tokens], dtype=np.int32),
        np.concatenate(tokens),
    )


def gather_trials(
    cases: Sequence[EpisodeCase],
    recipe: Recipe,
    plan: TrialPlan,
    cache: Path,
    mapper: Mapper,
    report: Callable[[CaseTrials], None] = lambda _trials: None,
) -> list[CaseTrials]:
    """Trials of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        cases: what to drive.
        recipe: policy and tokenizer.
        plan: how many trials, and how.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its trials are there.

    Raises:
        InputError: a case cannot be driven or is not driven as the corpus says, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    gathered: list[CaseTrials] = []
    for case, path in zip(cases, mapper(partial(_keep, recipe=recipe, plan=plan, cache=cache), cases), strict=True):
        trials = CaseTrials.load(path)
        if trials.name != case.name:
            raise InputError(str(path), f"holds case {trials.name}, not {case.name}", "remove the file")
        gathered.append(trials)
        report(trials)
    return gathered


def _keep(case: EpisodeCase, *, recipe: Recipe, plan: TrialPlan, cache: Path) -> Path:
    path = cache / f"{plan.key(case, recipe)}.npz"
    try:
        if path.exists():
            CaseTrials.load(path)
            return path
    except ValueError:
        pass  # a damaged file is made anew
    trials = try_case(case, recipe, plan)
    try:
        trials.save(path)
    except OSError as error:
        raise InputError(str(cache), f"cannot be written ({error.strerror})", "choose a writable folder") from None
    return path
