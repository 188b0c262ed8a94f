"""What it means that the user stops work: an error of its own, so that nobody reads it back from a sentence."""

from roadmend.core.errors import RoadmendError


class InterruptedWorkError(RoadmendError):
    """The user stopped the work; the command line exits with code 130.

    Args:
        resumes: words to add to the same command line so that it goes on with what is finished, separated by spaces;
            empty where it goes on by itself, None where there is nothing to go on with.
    """

    def __init__(self, resumes: str | None = None) -> None:
        super().__init__("interrupted")
        self.resumes = resumes
