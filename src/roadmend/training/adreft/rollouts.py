"""Rollouts: what a model at work would gain by acting at a moment, against leaving it to its own later decisions.

The paper fine-tunes its adapter by a DQN, which asks itself what its actions are worth (ADReFT section 3.2.2). Where
the world can be driven on from any moment there is no need to ask: each choice is played for as long as choices hold,
the model that is being tuned decides from there on, and what comes of it in several futures is counted (rollouts,
Tesauro and Galperin 1996; as policy improvement, Lagoudakis and Parr 2003). Waiting is one of the choices, in the same
futures; so an action earns nothing for what a later or gentler one would have averted as well, and pays for the time
that it loses.

Moments are those at which the monitor's score is not negligible: there alone the adapter will be asked.
"""

import random
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.fanout import Mapper
from roadmend.core.journal import Key, entry_key, file_of
from roadmend.core.outcome import EventKind
from roadmend.core.tick import INTERVAL
from roadmend.measures.answering import Answering
from roadmend.measures.need import HORIZON, LATER
from roadmend.policies.registry import make_policy
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.weighing import MILDEST
from roadmend.repair.guard import GuardedRepairer
from roadmend.training.adreft.case_rollouts import CaseRollouts
from roadmend.training.adreft.deferred import DeferredRepairer
from roadmend.training.adreft.gathering import Recipe, gather_files
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.futures import Future, Moment, futures
from roadmend.world.simulation import Simulation

_APART = round(0.3 / INTERVAL)  # ticks between two moments: nearer ones are the same
_SLOWEST = 3.0  # [m/s] at which a distance is made a time, at least: of one who creeps nothing is lost


@dataclass(frozen=True, slots=True)
class RolloutPlan:
    """How much is looked at."""

    moments: int  # of a drive, at most
    futures: int  # of a moment
    actions: int  # that are tried there
    score: float  # above which a moment is looked at
    chance: float  # that such a tick is, after the first
    seed: int
    guide: str  # digest of the model at work

    def numbers(self, case: str) -> random.Random:
        """Where the chance of a case comes from."""
        return random.Random(f"{self.seed}:{self.guide}{case}:rollouts")

    def tried(self, numbers: random.Random, asked: float) -> list[int]:
        """Indices into ACTIONS of what to try; only what brakes harder than the policy, ``asked``, throttle - brake."""
        harder = [index for index, action in enumerate(ACTIONS) if index >= MILDEST and action < asked]
        return sorted(numbers.sample(harder, min(self.actions, len(harder))))


class _RolloutNotes:
    """Takes down the moments of a drive."""

    def __init__(self, plan: RolloutPlan, pulse: float) -> None:
        self._plan, self._pulse = plan, pulse
        self.time: list[float] = []
        self.score: list[float] = []
        self.action: list[float] = []
        self.collided: list[float] = []
        self.tokens: list[NDArray[np.float16]] = []
        self.tried: list[tuple[int, int, float, float]] = []  # moment, choice, share that collides, seconds lost

    def add(
        self, moment: Moment, tokens: NDArray[np.float32], score: float, choices: Sequence[int], guide: GuardedRepairer
    ) -> None:
        """Look at a moment; the guide has not seen its tick yet."""
        now, asked = moment.tick.scene.time, moment.decision.command.action
        look = partial(self._futures, moment, guide, now + self._pulse)
        waited = look(None)
        for choice in choices:
            acted = look(choice)
            later = [
                _lost(*pair) for pair in zip(waited, acted, strict=True) if not any(future.collides for future in pair)
            ]
            share = float(np.mean([future.collides for future in acted]))
            self.tried.append((len(self.time), choice, share, float(np.mean(later)) if later else 0.0))
        self.time.append(now)
        self.score.append(score)
        self.action.append(asked)
        self.collided.append(float(np.mean([future.collides for future in waited])))
        self.tokens.append(tokens.astype(np.float16))

    def _futures(self, moment: Moment, guide: GuardedRepairer, until: float, choice: int | None) -> list[Future]:
        deferred = DeferredRepairer(guide, until, choice)
        return futures(moment, deferred, range(1, self._plan.futures + 1), HORIZON + LATER)

    def result(self, name: str, outcome: str, attributes: int) -> CaseRollouts:
        """All of it."""
        moment, choice, collided, lost = np.array(self.tried, dtype=np.float64).reshape(-1, 4).T
        return CaseRollouts(
            name,
            outcome,
            np.array(self.time),
            np.array(self.score, dtype=np.float32),
            np.array(self.action, dtype=np.float32),
            np.array(self.collided, dtype=np.float32),
            np.array([len(one) for one in self.tokens], dtype=np.int32),
            np.concatenate([np.empty((0, attributes), dtype=np.float16), *self.tokens]),
            moment.astype(np.int32),
            choice.astype(np.int8),
            collided.astype(np.float32),
            lost.astype(np.float32),
        )


def _lost(waited: Future, acted: Future) -> float:
    """Seconds by which the second is behind the first; negative where it is ahead.

    Whoever leaves its route or stands until the time is up has ended, but not arrived: of those the way tells, and to
    lose the goal is never a gain.
    """
    arrived, arrives = (each.final is not None and each.final.kind is EventKind.GOAL for each in (waited, acted))
    if arrived and arrives:
        return acted.duration - waited.duration
    speed = max(_SLOWEST, waited.driven / max(waited.duration, INTERVAL))
    behind = (waited.driven - acted.driven) / speed
    return max(0.0, behind) if arrived else behind


def rollouts_of_case(case: EpisodeCase, recipe: Recipe, plan: RolloutPlan, guide: Path) -> CaseRollouts:
    """Drive one case with the model at work, in this process, and look at its moments.

    Args:
        case: what to drive.
        recipe: policy and tokenizer.
        plan: how much of it.
        guide: file of the model.

    Raises:
        InputError: the scenario or the model is unusable.
        SimulationError: SUMO failed.
    """
    model = AdreftModel.load(guide)
    judge, guarded = AdreftModel.load(guide), GuardedRepairer(AdreftRepair(model=model))
    repairer = Answering(guarded)
    policy, tokenizer = make_policy(recipe.policy), model.tokenizer()
    notes = _RolloutNotes(plan, model.configuration.interval * INTERVAL)
    numbers, last = plan.numbers(case.name), -_APART
    with Simulation(case.scenario()) as simulation:
        for part in (policy, tokenizer, repairer):
            part.reset(simulation.route)
        tick = simulation.first()
        while tick.final is None:
            decision = policy.step(tick.scene)
            asked = decision.command.action
            tokens = tokenizer.tokens(tick.scene, decision).values  # at every tick: it remembers
            score = judge.score(judge.encode(tokens), asked)
            if len(notes.time) < plan.moments and score > plan.score and tick.number - last >= _APART:
                chosen = plan.tried(numbers, asked)
                if chosen and (not notes.time or numbers.random() < plan.chance):
                    notes.add(Moment(simulation, tick, decision, policy), tokens, score, chosen, guarded)
                    last = tick.number
            tick = simulation.step(repairer.step(tick.scene, decision).command)
    return notes.result(case.name, tick.final.kind.name, tokenizer.attributes)


def gather_rollouts(
    cases: Sequence[EpisodeCase],
    recipe: Recipe,
    plan: RolloutPlan,
    guide: Path,
    cache: Path,
    mapper: Mapper,
    report: Callable[[CaseRollouts], None] = lambda _rollouts: None,
) -> list[CaseRollouts]:
    """Rollouts of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        cases: what to drive.
        recipe: policy and tokenizer.
        plan: how much; it knows the digest of the guide.
        guide: file of the model at work.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its rollouts are there.

    Raises:
        InputError: a case or the model is unusable, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    keys: list[Key] = [entry_key([__name__], key, asdict(plan)) for key in recipe.keys(cases)]
    places = [(case, file_of(cache, key, ".npz")) for case, key in zip(cases, keys, strict=True)]
    look = partial(rollouts_of_case, recipe=recipe, plan=plan, guide=guide)
    return gather_files(places, look, CaseRollouts, mapper, report)
