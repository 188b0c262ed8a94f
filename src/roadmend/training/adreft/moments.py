"""Moments: what comes of the policy left alone, and of a short pulse of braking, told by futures of the same tick.

What a single episode comes to is one draw; a label of it is 0 or 1 where the truth lies between. So some moments of a
drive are driven on several times in worlds that differ as they may, and once more in each of the same worlds with a
pulse of braking first: of the futures that violate, how many does it avert, and how many collisions does it cause.

A violation is a collision by the ego's own fault within HORIZON. An averted one must not come LATER either, and must
leave no collision of another kind; a collision counts as caused whosever fault it is, for braking provokes those of
others.

Moments are taken of the policy's own drive and of drives with pulses at random times, so that the middle of a braking
and what comes after it are seen; in later rounds of drives with a model at work, which stands where none else does.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.fanout import Mapper
from roadmend.core.interfaces import Repairer
from roadmend.core.journal import Key, entry_key, file_of
from roadmend.measures.answering import Answering
from roadmend.measures.need import HORIZON, LATER
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.case_moments import CaseMoments
from roadmend.training.adreft.gathering import Recipe, gather_files
from roadmend.training.adreft.holding import HoldingRepairer
from roadmend.training.adreft.moment_plan import MomentPlan
from roadmend.training.adreft.trial_plan import Hold
from roadmend.training.closed_loop import EpisodeCase, check_driven
from roadmend.world.futures import Future, Moment, futures
from roadmend.world.runner import run_episode
from roadmend.world.simulation import Simulation

_TICK = 1e-6  # [s] slack against rounding


class _MomentNotes:
    """Takes down the moments of a case, drive after drive."""

    def __init__(self, plan: MomentPlan) -> None:
        self._plan = plan
        self.time: list[float] = []
        self.span: list[float] = []
        self.action: list[float] = []
        self.danger: list[float] = []
        self.tokens: list[NDArray[np.float16]] = []
        self.tried: list[tuple[int, int]] = []  # moment and choice
        self.averted: list[list[bool]] = []  # of the futures that violate alone
        self.caused: list[list[bool]] = []  # of the futures that do not collide alone

    def add(self, drive: str, moment: Moment, tokens: NDArray[np.float32], span: float) -> None:
        """Look at a moment that stands for ``span`` [s] of a drive."""
        now, asked, number = moment.tick.scene.time, moment.decision.command.action, moment.tick.number
        alone = self._futures(moment, HoldingRepairer())
        violates = [future.violates and future.duration <= HORIZON + _TICK for future in alone]
        for choice in self._plan.tried(drive, number, asked, dangerous=any(violates)):
            pulsed = self._futures(moment, HoldingRepairer((Hold(now, now + self._plan.pulse, choice),)))
            pairs = list(zip(alone, pulsed, violates, strict=True))
            self.tried.append((len(self.time), choice))
            self.averted.append([not after.collides for _, after, violated in pairs if violated])
            self.caused.append([after.collides for before, after, _ in pairs if not before.collides])
        self.time.append(now)
        self.span.append(span)
        self.action.append(asked)
        self.danger.append(float(np.mean(violates)))
        self.tokens.append(tokens.astype(np.float16))

    def _futures(self, moment: Moment, repairer: Repairer) -> list[Future]:
        return futures(moment, repairer, range(1, self._plan.futures + 1), HORIZON + LATER)

    def result(self, name: str, *, violates: bool, attributes: int) -> CaseMoments:
        """All of it."""
        return CaseMoments(
            name,
            violates,
            self._plan.futures,
            np.array(self.time),
            np.array(self.span, dtype=np.float32),
            np.array(self.action, dtype=np.float32),
            np.array(self.danger, dtype=np.float32),
            np.array([len(one) for one in self.tokens], dtype=np.int32),
            np.concatenate([np.empty((0, attributes), dtype=np.float16), *self.tokens]),
            np.array([moment for moment, _ in self.tried], dtype=np.int32),
            np.array([choice for _, choice in self.tried], dtype=np.int8),
            _shares(self.averted),
            _shares(self.caused),
            np.array([len(each) for each in self.averted], dtype=np.int32),
            np.array([len(each) for each in self.caused], dtype=np.int32),
        )


def _shares(found: Sequence[Sequence[bool]]) -> NDArray[np.float32]:
    return np.array([np.mean(each) if each else np.nan for each in found], dtype=np.float32)


def moments_of_case(case: EpisodeCase, recipe: Recipe, plan: MomentPlan, guide: Path | None = None) -> CaseMoments:
    """Look at the moments of one case in this process.

    Args:
        case: what to drive.
        recipe: policy and tokenizer.
        plan: how much of it.
        guide: file of the model that drives along; without one, the policy drives alone and with random pulses.

    Raises:
        InputError: the scenario is unusable, or the policy drives it otherwise than the corpus says.
        SimulationError: SUMO failed.
    """
    own = run_episode(case.scenario(), make_policy(recipe.policy), make_repairer("none"))
    check_driven(case, recipe.policy, own.digest)
    violates = own.collided and own.final.at_fault
    repairers: dict[str, Repairer] = {}
    if guide is not None:
        # By its class, not by its name: so the code of the method is part of what moments are kept by.
        repairers["guided"] = Answering(GuardedRepairer(AdreftRepair(model=AdreftModel.load(guide))))
    else:
        repairers["alone"] = HoldingRepairer()
        for number in range(1, plan.pulsed + 1):
            drive = f"{case.name}:pulsed-{number}"
            repairers[f"pulsed-{number}"] = HoldingRepairer(plan.pulses(drive, own.duration))
    notes = _MomentNotes(plan)
    for manner, repairer in repairers.items():
        drive = f"{case.name}:{manner}"
        ticks = plan.ticks(drive, own.duration, violates=violates, alone=manner == "alone")
        _drive(case, recipe, repairer, ticks, partial(notes.add, drive))
    return notes.result(case.name, violates=violates, attributes=make_tokenizer(recipe.tokenizer).attributes)


def _drive(
    case: EpisodeCase,
    recipe: Recipe,
    repairer: Repairer,
    ticks: dict[int, float],
    look: Callable[[Moment, NDArray[np.float32], float], None],
) -> None:
    """Drive until the last of the ticks to look at, or to the end; ``ticks`` gives the span that each stands for."""
    policy, tokenizer = make_policy(recipe.policy), make_tokenizer(recipe.tokenizer)
    last = max(ticks, default=-1)
    with Simulation(case.scenario()) as simulation:
        for part in (policy, tokenizer, repairer):
            part.reset(simulation.route)
        tick = simulation.first()
        while tick.final is None and tick.number <= last:
            decision = policy.step(tick.scene)
            tokens = tokenizer.tokens(tick.scene, decision)  # at every tick: it may remember
            repair = repairer.step(tick.scene, decision)
            if tick.number in ticks:
                look(Moment(simulation, tick, decision, policy), tokens.values, ticks[tick.number])
            tick = simulation.step(repair.command)


def gather_moments(
    cases: Sequence[EpisodeCase],
    recipe: Recipe,
    plan: MomentPlan,
    cache: Path,
    mapper: Mapper,
    report: Callable[[CaseMoments], None] = lambda _moments: None,
    guide: Path | None = None,
) -> list[CaseMoments]:
    """Moments of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        cases: what to drive.
        recipe: policy and tokenizer.
        plan: how much, and where.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its moments are there.
        guide: file of the model that drives along; ``plan`` knows its digest.

    Raises:
        InputError: a case cannot be driven or is not driven as the corpus says, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    keys = moment_keys(cases, recipe, plan)
    places = [(case, file_of(cache, key, ".npz")) for case, key in zip(cases, keys, strict=True)]
    look = partial(moments_of_case, recipe=recipe, plan=plan, guide=guide)
    return gather_files(places, look, CaseMoments, mapper, report)


def moment_keys(cases: Sequence[EpisodeCase], recipe: Recipe, plan: MomentPlan) -> list[Key]:
    """Of the moments of cases."""
    return [entry_key([__name__], key, asdict(plan)) for key in recipe.keys(cases)]
