"""A repair method from outside, as the guard has it."""

from dataclasses import replace
from typing import Any

from roadmend.core.command import Decision
from roadmend.core.errors import ForeignError
from roadmend.core.foreign import blamed_on, number_of
from roadmend.core.plain_moment import PlainMoment
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.method import RepairMethod


class ForeignMethod:
    """Passes everything on, and says where it failed; the guard around it answers then, as for any method.

    Called as it was asked for, so it is found again. A method that works with a model of its own says the model's
    SHA-256, hexadecimal, as ``model_digest``; results are kept by it.
    """

    def __init__(self, given: str, method: RepairMethod) -> None:
        self.name = given
        self.method = method
        self.model_digest: str | None = getattr(method, "model_digest", None)

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``.

        Raises:
            ForeignError: it fails.
        """
        with blamed_on("reset"):
            self.method.reset(route)

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick.

        Raises:
            ForeignError: it fails, or answers with something else than a proposal.
        """
        where = f"propose at {scene.time:.2f} s"  # the guard says of whom
        with blamed_on(where):
            proposal: Any = self.method.propose(scene, decision)
        if not isinstance(proposal, Proposal):
            what = f"answered with {type(proposal).__name__}"
            raise ForeignError(where, what, "answer with a roadmend.core.repair.Proposal")
        names = ("score", "threshold", "action")
        score, threshold, action = (self._number(name, getattr(proposal, name), where) for name in names)
        return replace(proposal, score=score, threshold=threshold, action=action)

    def _number(self, name: str, given: Any, where: str) -> float:
        """Of an array the guard would find only that no message holds it, and not whose it was."""
        try:
            return number_of(given)
        except TypeError:
            what = f"answered with a Proposal whose {name} is of type {type(given).__name__}"
            raise ForeignError(where, what, "answer with a number") from None

    def answer(self, moment: PlainMoment) -> None:
        """Answer it, for ``core.foreign.check_answers``."""
        self.reset(moment.route)
        self.propose(moment.scene, moment.decision)
