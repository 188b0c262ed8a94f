"""What came of driving a scenario: an episode, or the error that there is none for."""

from dataclasses import dataclass

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import RoadmendError, SimulationError

CRASH = "CRASH"  # outcome of an attempt that an error ended


@dataclass(frozen=True, slots=True)
class Attempt:
    """What an episode came to, or why there is none."""

    result: EpisodeResult | None
    fault: str  # one line; empty where there is a result

    @property
    def outcome(self) -> str:
        """An EventKind's name, or CRASH."""
        return CRASH if self.result is None else self.result.outcome.name

    @property
    def text(self) -> str:
        """How it ended, in a sentence for people."""
        return self.fault if self.result is None else self.result.text

    @property
    def digest(self) -> str:
        """Of the trajectory; empty after a crash."""
        return "" if self.result is None else self.result.digest


def fault_of(error: Exception) -> str:
    """What is kept of an error that the scenario causes, since it would come again.

    Raises:
        RoadmendError: the machine is the cause, as of a full disk, a folder that cannot be written or too little memory.
            That passes, and whoever kept it would never try again.
    """
    text = " ".join(f"{type(error).__name__}: {error}".split())
    if _is_passing(error):
        if isinstance(error, RoadmendError):
            raise error
        raise SimulationError(f"{text}; mend that and run the same command again to go on") from error
    return text


def _is_passing(error: BaseException) -> bool:
    """Whether the system refused something; an error of ours that tells of it was raised while that was handled."""
    link: BaseException | None = error
    while link is not None:
        if isinstance(link, OSError | MemoryError):
            return True
        link = link.__cause__ or link.__context__
    return False
