"""What came of driving a scenario: an episode, or the error that there is none for."""

from dataclasses import dataclass

from roadmend.core.episode_result import EpisodeResult

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
    """What is kept of an error."""
    return " ".join(f"{type(error).__name__}: {error}".split())
