"""Who drew a model's attention."""

import numpy as np
from numpy.typing import NDArray

from roadmend.core.repair import RepairTrigger
from roadmend.core.scene import Scene
from roadmend.repair.adreft.tokenizer import TokenSet

_TRIGGERS = 3  # participants named at most


def attended(attention: NDArray[np.float32], tokens: TokenSet, scene: Scene) -> tuple[RepairTrigger, ...]:
    """The participants that drew most attention in a model's last call, the weightiest first.

    Args:
        attention: of each token, shape (N,).
        tokens: the N tokens.
        scene: what they were made of.
    """
    rows = tokens.object_rows
    named = rows >= 0
    weights = np.bincount(rows[named], attention[named], minlength=len(scene.objects))
    ranked = np.argsort(-weights, kind="stable")[:_TRIGGERS]
    return tuple(RepairTrigger(int(scene.objects.id[row]), float(weights[row])) for row in ranked if weights[row] > 0.0)
