"""What one case came to under one repair method."""

from dataclasses import dataclass
from typing import Any, Self

from roadmend.core.episode_result import EpisodeResult


@dataclass(frozen=True, slots=True)
class CaseResult:
    """One case of a corpus under one method. Holds no time and no place: a rerun gives the same."""

    case: str
    family: str
    is_violation: bool  # whether the policy alone collides in it
    episode: EpisodeResult

    def dump(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "case": self.case,
            "family": self.family,
            "is_violation": self.is_violation,
            "episode": self.episode.dump(),
        }

    @classmethod
    def parse(cls, content: dict[str, Any]) -> Self:
        """From plain values.

        Raises:
            ValueError: they are no result.
        """
        try:
            return cls(**{**content, "episode": EpisodeResult.parse(content["episode"])})
        except (KeyError, TypeError) as error:
            raise ValueError(str(error)) from None
