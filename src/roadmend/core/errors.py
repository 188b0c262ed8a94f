"""Errors that are meant for people."""

from typing import overload


class RoadmendError(Exception):
    """Base of every error that roadmend raises on purpose."""


class PlacedError(RoadmendError):
    """An error that has a place and a remedy; the message is one line of all three.

    Args:
        where: the file, field, argument or code at fault.
        what: what is wrong with it.
        mend: what the user can do about it.
    """

    where: str
    what: str
    mend: str

    @overload
    def __init__(self, where: str, what: str, mend: str) -> None: ...

    @overload
    def __init__(self, where: "PlacedError") -> None: ...

    def __init__(self, where: "str | PlacedError", what: str = "", mend: str = "") -> None:
        if isinstance(where, PlacedError):
            # Who hands on what a worker process raised may make it anew from itself, kind(error), as Gymnasium does.
            self.where, self.what, self.mend = where.where, where.what, where.mend
        else:
            self.where, self.what, self.mend = where, what, mend
        # What is quoted of a file may have line ends of its own.
        super().__init__(" ".join(f"{self.where}: {self.what}; {self.mend}".splitlines()))

    def __reduce__(self) -> tuple[type["PlacedError"], tuple[str, str, str]]:
        """So that it comes out of a worker process as it went in; without, the worker's pool breaks instead."""
        return type(self), (self.where, self.what, self.mend)


class InputError(PlacedError):
    """A file, field or argument given by the user is unusable; the command line exits with code 2."""


class SimulationError(RoadmendError):
    """SUMO failed while an episode was running."""


class ForeignError(PlacedError):
    """Code from outside, such as a policy of the user's own, failed while it was at work."""
