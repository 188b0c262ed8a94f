"""What can go wrong while a bag is written, beyond bad input."""

from roadmend.core.errors import RoadmendError


class RecordingError(RoadmendError):
    """A bag cannot be written any further, for example because the disk is full.

    Args:
        path: the file at fault.
        what: what is wrong with it.
    """

    def __init__(self, path: str, what: str) -> None:
        super().__init__(f"{path}: {what}")
        self.path = path
        self.what = what
