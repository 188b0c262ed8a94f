"""A repair method that fails on the way: the guard's rule then drives in its place."""

from roadmend.core.parameters import NoParameters
from roadmend.repair.none import NO_OPINION
from roadmend.repair.registry import MethodEntry


class FailingMethod:
    """Has no opinion for a while, then fails."""

    name = "failing"

    def __init__(self, ticks=5):
        self._left = ticks

    def reset(self, route):
        pass

    def propose(self, scene, decision):
        self._left -= 1
        if self._left < 0:
            raise KeyError("lost")
        return NO_OPINION


ENTRY = MethodEntry(NoParameters, lambda _parameters, _seed: FailingMethod())  # for the table of methods
SAID = "failing failed: KeyError('lost')"
