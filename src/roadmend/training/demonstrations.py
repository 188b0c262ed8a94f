"""Gathers what a neural policy learns from: scenes that a driver meets, each with what the expert would do there."""

import random
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.measures.answering import Answering
from roadmend.policies.expert import Expert
from roadmend.policies.neural import NeuralPolicy
from roadmend.policies.neural_observer import Observer
from roadmend.policies.neural_tokens import COLUMNS
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.parameters import AdreftParameters
from roadmend.repair.registry import make_repairer
from roadmend.training.samples import UNASKED, Samples
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Lesson:
    """One episode to gather."""

    scenario: Scenario
    draw: str  # what disturbances and turns at the wheel are drawn from
    model: Path | None  # the learner; None: the expert drives
    expert_share: float  # of the time during which the expert drives although there is a learner
    noise: float  # standard deviation of the disturbances of the expert's action
    every: int  # ticks between two samples
    repair: Path | None = None  # model of ADReFT that repairs what the expert advises; None: the expert as it is


class Tutor:
    """A policy for gathering: the expert advises at every tick; it, the learner, or it with disturbances drives.

    Where a scenario is hard, the expert may fail in it as well. Then what ADReFT makes of its advice is advised.
    """

    name = "tutor"

    def __init__(self, lesson: Lesson) -> None:
        self._lesson = lesson
        self._random = random.Random(f"roadmend/lesson/{lesson.draw}/{lesson.model is not None}")
        self._expert = Expert()
        self._expert.privilege(lesson.scenario.environment.effective_friction)
        # By its class, not by its name: so the code of the method is part of what lessons are kept by.
        own = AdreftParameters(model=str(lesson.repair))
        self._repairer = None if lesson.repair is None else Answering(GuardedRepairer(AdreftRepair(own)))
        self._learner = NeuralPolicy(lesson.model) if lesson.model is not None else None
        self._observer = self._learner.observer if self._learner is not None else Observer()
        self._tick = 0
        self._until = 0  # tick at which driver and disturbance are drawn again
        self._learner_drives = False
        self._disturbance = 0.0
        self.tokens: list[NDArray[np.float16]] = []
        self.actions: list[float] = []
        self.changes: list[int] = []

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._expert.reset(route)
        self._observer.reset(route)
        if self._repairer is not None:
            self._repairer.reset(route)

    def step(self, scene: Scene) -> Decision:
        """Note the scene with the expert's advice, and drive."""
        advice = self._expert.step(scene)
        tokens = self._observer.observe(scene)
        asked = tokens is not None and self._observer.may_change
        command = advice.command if self._repairer is None else self._repairer.step(scene, advice).command
        if tokens is not None and (self._tick % self._lesson.every == 0 or (asked and command.change_lane)):
            self.tokens.append(tokens.astype(np.float16))
            self.actions.append(command.action)
            self.changes.append(int(command.change_lane) if asked else UNASKED)
        self._draw()
        answer = self._drive(tokens, command, asked=asked)
        self._expert.obeyed(change=answer.change_lane)
        if answer.change_lane:
            self._observer.begin_change()
        self._tick += 1
        return Decision(answer, advice.trajectory)

    def _draw(self) -> None:
        """Who drives for the next while, and how much off the expert's advice it is if the expert does."""
        if self._tick < self._until:
            return
        lesson, draw = self._lesson, self._random
        self._until = self._tick + draw.randint(20, 80)
        self._learner_drives = self._learner is not None and draw.random() >= lesson.expert_share
        self._disturbance = 0.0
        if not self._learner_drives and draw.random() < 0.3:
            self._until = self._tick + draw.randint(8, 30)
            self._disturbance = draw.gauss(0.0, lesson.noise)

    def _drive(self, tokens: NDArray[np.float32] | None, advice: Command, *, asked: bool) -> Command:
        if self._learner is not None and self._learner_drives and tokens is not None:
            return self._learner.decide(tokens)
        # A gap is not always taken at once, so that the learner sees some more of them.
        change = advice.change_lane and asked and self._random.random() < 0.15
        action = min(max(advice.action + self._disturbance, -1.0), 1.0)
        return Command.from_action(action, change_lane=change)


def ordinary_lesson(
    family: str,
    seed: int,
    model: Path | None,
    expert_share: float,
    noise: float,
    every: int,
    repair: Path | None = None,
) -> Lesson:
    """A lesson in a random scenario of a family."""
    return Lesson(sample_scenario(family, seed), f"{family}/{seed}", model, expert_share, noise, every, repair)


def gather(lesson: Lesson) -> Samples:
    """Run one episode and return what was noted."""
    tutor = Tutor(lesson)
    summary = run_episode(lesson.scenario, tutor, make_repairer("none"))
    counts = np.array([len(tokens) for tokens in tutor.tokens], dtype=np.int16)
    flat = np.concatenate(tutor.tokens) if tutor.tokens else np.empty((0, COLUMNS), dtype=np.float16)
    return Samples(
        flat,
        counts,
        np.array(tutor.actions, dtype=np.float32),
        np.array(tutor.changes, dtype=np.int8),
        np.zeros(len(counts), dtype=np.int32),
        (summary.outcome.name,),
    )
