"""A policy from outside, as roadmend drives with it."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import ForeignError
from roadmend.core.foreign import blamed_on, is_text, number_of
from roadmend.core.interfaces import Policy
from roadmend.core.plain_moment import PlainMoment
from roadmend.core.route import Route
from roadmend.core.scene import Scene

_PEDALS = ("throttle", "brake")


class ForeignPolicy:
    """Passes everything on, and says in one line what went wrong. Called as it was asked for, so it is found again.

    A policy that drives with a model of its own says the model's SHA-256, hexadecimal, as ``model_digest``; results are
    kept by it.
    """

    def __init__(self, given: str, policy: Policy) -> None:
        self.name = given
        self.policy = policy
        self.model_digest: str | None = getattr(policy, "model_digest", None)
        self._where = f"policy {given}"

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``.

        Raises:
            ForeignError: it fails.
        """
        with blamed_on(self._where, "reset"):
            self.policy.reset(route)

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick.

        Raises:
            ForeignError: it fails, or answers with something else than a decision.
        """
        with blamed_on(self._where, f"step at {scene.time:.2f} s"):
            decision: Any = self.policy.step(scene)
        if not isinstance(decision, Decision):
            raise self._no_decision(scene.time, "a roadmend.core.command.Decision", decision)
        if not isinstance(decision.command, Command):
            raise self._no_decision(scene.time, "a Decision with a Command", decision.command)
        if not isinstance(decision.trajectory, Trajectory):
            raise self._no_decision(
                scene.time, "a Decision with a Trajectory (Trajectory.empty())", decision.trajectory
            )
        return self._with_numbers(decision, scene.time)

    def _with_numbers(self, decision: Decision, time: float) -> Decision:
        """The decision, in plain numbers where it has arrays, lists or other numbers; what they say is the guard's."""
        command, plan = decision.command, decision.trajectory
        throttle, brake = (self._number(f"a Command whose {name}", getattr(command, name), time) for name in _PEDALS)
        if not isinstance(command.change_lane, bool | np.bool_):
            raise self._no_decision(time, "a Command whose change_lane is True or False", command.change_lane)
        decision = replace(decision, command=Command(throttle, brake, bool(command.change_lane)))
        interval = self._number("a Trajectory whose interval", plan.interval, time)
        if not is_text(plan.behaviour):
            raise self._no_decision(time, "a Trajectory whose behaviour is a text", plan.behaviour)
        given = (plan.x, plan.y, plan.yaw, plan.speed)
        rows = [self._row(name, row, time) for name, row in zip(("x", "y", "yaw", "speed"), given, strict=True)]
        if interval is plan.interval and all(row is before for row, before in zip(rows, given, strict=True)):
            return decision
        x, y, yaw, speed = rows
        return replace(decision, trajectory=Trajectory(interval, x, y, yaw, speed, plan.behaviour))

    def _number(self, whose: str, given: Any, time: float) -> float:
        try:
            return number_of(given)
        except TypeError:
            raise self._no_decision(time, f"{whose} is a number", given) from None

    def _row(self, name: str, given: Any, time: float) -> NDArray[np.float64]:
        try:
            row = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            row = np.empty(())
        if row.ndim != 1:
            raise self._no_decision(time, f"a Trajectory whose {name} is a row of numbers", given)
        return row

    def _no_decision(self, time: float, wanted: str, answer: Any) -> ForeignError:
        what = f"its step at {time:.2f} s answered with {type(answer).__name__}"
        return ForeignError(self._where, what, f"answer with {wanted}")

    def answer(self, moment: PlainMoment) -> None:
        """Answer it, for ``core.foreign.check_answers``."""
        self.reset(moment.route)
        self.step(moment.scene)
