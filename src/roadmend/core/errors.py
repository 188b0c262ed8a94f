"""Errors that are meant for people."""


class RoadmendError(Exception):
    """Base of every error that roadmend raises on purpose."""


class InputError(RoadmendError):
    """A file, field or argument given by the user is unusable.

    The command line prints the message as one line and exits with code 2.

    Args:
        where: the file, field or argument at fault.
        what: what is wrong with it.
        mend: what the user can do about it.
    """

    def __init__(self, where: str, what: str, mend: str) -> None:
        super().__init__(f"{where}: {what}; {mend}")
        self.where = where
        self.what = what
        self.mend = mend

    def __reduce__(self) -> tuple[type["InputError"], tuple[str, str, str]]:
        """So that it comes out of a worker process as it went in; without, the worker's pool breaks instead."""
        return type(self), (self.where, self.what, self.mend)


class SimulationError(RoadmendError):
    """SUMO failed while an episode was running."""


class ForeignError(RoadmendError):
    """Code from outside, such as a policy of the user's own, failed while it was at work."""
