"""Trials: episodes in which the policy is interfered with at random, to learn what an intervention is worth.

The paper explores tick by tick (ADReFT algorithm 1); a tick of braking changes nothing that could be learned from. A
trial holds an action for a while, as an intervention does, and it begins where it may matter: in the seconds before
the collision that the policy alone would have. Gentle trials hold a mild action for long and begin well before: where
a car alongside may cut in, nothing shorter shows what it is worth to fall back a little. Collisions of other kinds than
a search finds come from successes that the policy drives without seeing everybody.

In later rounds a model drives along: what it does not hold at random is its own, so that the next model learns what
comes of its own interventions, and where they are too few or too many.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import ArrayRecord
from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.fanout import Mapper
from roadmend.core.journal import Key, entry_key, file_of
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Repair, played
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import INTERVAL, Tick
from roadmend.policies.registry import make_policy
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer, TokenSet
from roadmend.training.adreft.blinded_policy import BlindedPolicy, Blindness, draw_blindness
from roadmend.training.adreft.gathering import Recipe, gather_files
from roadmend.training.adreft.holding import valid_command
from roadmend.training.adreft.trial_plan import Hold, TrialPlan
from roadmend.training.closed_loop import EpisodeCase, check_driven
from roadmend.world.runner import run_episode

PASS = -1  # in the place of an action: the policy's own
_LEAD = 0.2  # [s] before the first intervention from which a trial is kept: before that it is the episode untouched


@dataclass(frozen=True, slots=True, eq=False)
class CaseTrials(ArrayRecord):
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


class _Trial:
    """A repairer that plays its holds, leaves the rest to the guide, and keeps a decision every ``interval`` ticks."""

    name = "trial"

    def __init__(
        self, tokenizer: Tokenizer, holds: Sequence[Hold], interval: int, guide: AdreftModel | None = None
    ) -> None:
        self._tokenizer, self._holds, self._interval, self._guide = tokenizer, holds, interval, guide
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
        command = valid_command(decision)
        asked = command.action
        if self._tick % self._interval == 0:
            now = scene.time
            held = next((hold.action for hold in self._holds if hold.begin <= now < hold.end), None)
            self._choice = self._guided(tokens, asked) if held is None else held
            if now >= self._since:
                self.time.append(now)
                self.action.append(asked)
                self.choice.append(self._choice)
                self.dose.append(0.0)
                self.distance.append(np.inf)
                self.tokens.append(tokens.values.astype(np.float16))
        self._tick += 1
        wanted = asked if self._choice == PASS else ACTIONS[self._choice]
        return played(command, wanted)

    def _guided(self, tokens: TokenSet, asked: float) -> int:
        """What the guide would do; without one, nothing."""
        if self._guide is None:
            return PASS
        state = self._guide.encode(tokens.values)
        if self._guide.score(state, asked) <= self._guide.threshold:
            return PASS
        return int(self._guide.values(state, asked).argmax())

    def watch(self, tick: Tick, _decision: Decision, repair: Repair) -> None:
        """Credit the tick that was just answered to the last decision."""
        if self.time:
            self.dose[-1] += (repair.policy_action - repair.final_action) * INTERVAL
            self.distance[-1] = min(self.distance[-1], tick.min_distance)


def try_case(case: EpisodeCase, recipe: Recipe, plan: TrialPlan, guide: Path | None = None) -> CaseTrials:
    """Drive all trials of one case in this process; ``guide`` is the file of the model that drives along.

    Raises:
        InputError: the scenario is unusable, or the policy drives it otherwise than the corpus says.
        SimulationError: SUMO failed.
    """
    driven: list[tuple[_Trial, EpisodeResult]] = []
    model = None if guide is None else AdreftModel.load(guide)

    def drive(holds: Sequence[Hold], blindness: Blindness | None = None) -> EpisodeResult:
        trial = _Trial(make_tokenizer(recipe.tokenizer), holds, plan.interval, model)
        policy = make_policy(recipe.policy)
        driver = policy if blindness is None else BlindedPolicy(policy, blindness)
        summary = run_episode(case.scenario(), driver, trial, trial.watch)
        if trial.time:
            driven.append((trial, summary))
        return summary

    alone = drive(())
    if model is None:
        check_driven(case, recipe.policy, alone.digest)
    known = case.name, alone.outcome, alone.duration
    for holds in chain(plan.trials(*known), plan.gentle_trials(*known)):
        drive(holds)
    for index in range(0 if alone.outcome == EventKind.COLLISION else plan.blinded):
        name = f"{case.name}:blinded-{index}"
        blindness = draw_blindness(f"{plan.seed}:{name}", alone.duration)
        first = drive((), blindness)
        if first.outcome == EventKind.COLLISION:
            for holds in plan.trials(name, first.outcome, first.duration):
                drive(holds, blindness)
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
    guide: Path | None = None,
) -> list[CaseTrials]:
    """Trials of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        cases: what to drive.
        recipe: policy and tokenizer.
        plan: how many trials, and how.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its trials are there.
        guide: file of the model that drives along; ``plan`` knows its digest.

    Raises:
        InputError: a case cannot be driven or is not driven as the corpus says, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    keys = trial_keys(cases, recipe, plan)
    places = [(case, file_of(cache, key, ".npz")) for case, key in zip(cases, keys, strict=True)]
    drive = partial(try_case, recipe=recipe, plan=plan, guide=guide)
    return gather_files(places, drive, CaseTrials, mapper, report)


def trial_keys(cases: Sequence[EpisodeCase], recipe: Recipe, plan: TrialPlan) -> list[Key]:
    """Of the trials of cases."""
    return [entry_key([__name__], key, asdict(plan)) for key in recipe.keys(cases)]
