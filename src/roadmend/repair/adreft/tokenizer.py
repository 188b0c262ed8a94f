"""What turns a scene and the policy's plan into tokens for the scene encoder."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.route import Route
from roadmend.core.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class TokenSet:
    """N tokens of one tick; the arrays belong to whoever got them and are never written again."""

    values: NDArray[np.float32]  # shape (N, c)
    object_rows: NDArray[np.int32]  # shape (N,): index into Scene.objects of what a token stands for, -1 for none

    def __len__(self) -> int:
        return len(self.values)


class Tokenizer(Protocol):
    """Deterministic: the same scenes and decisions after the same reset give the same tokens.

    Any number of participants gives tokens, none is left out silently; N may be 0.
    """

    name: str  # in the registry and in a model's configuration
    version: int  # grows with every change of what comes out, so that no model is fed with what it does not know
    attributes: int  # c
    has_ego: bool  # whether the last token is the ego's own

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory is dropped."""

    def tokens(self, scene: Scene, decision: Decision) -> TokenSet:
        """Tokens of one tick. The inputs are as a RepairMethod gets them: finite and usable."""
