"""A repair method from outside, as the guard has it."""

from typing import Any

from roadmend.core.command import Decision
from roadmend.core.errors import ForeignError, InputError
from roadmend.core.foreign import trouble_of
from roadmend.core.plain_moment import plain_moment
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
        try:
            self.method.reset(route)
        except Exception as error:
            raise ForeignError(trouble_of(error)) from error

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick.

        Raises:
            ForeignError: it fails, or answers with something else than a proposal.
        """
        try:
            proposal: Any = self.method.propose(scene, decision)
        except Exception as error:
            raise ForeignError(trouble_of(error)) from error
        if not isinstance(proposal, Proposal):
            raise ForeignError(f"propose answered with {type(proposal).__name__}, not a roadmend.core.repair.Proposal")
        return proposal


def check_answers(method: ForeignMethod) -> None:
    """Ask a method about a plain moment: what fails there would be decided by the guard's rule, and shown as its own.

    Args:
        method: an instance that nothing is driven with.

    Raises:
        InputError: it has no answer.
    """
    moment = plain_moment()
    try:
        method.reset(moment.route)
        method.propose(moment.scene, moment.decision)
    except ForeignError as error:
        what = f"cannot answer a plain scene: {error}"
        raise InputError(f"repair method {method.name}", what, "mend the class") from None
