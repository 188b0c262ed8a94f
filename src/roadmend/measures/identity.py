"""Who drives, as a digest: what was measured of one policy, model or version of the code says nothing about another."""

import hashlib
import json
from pathlib import Path

from roadmend.core.source_digest import source_digest
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import METHODS

_ALWAYS = (
    "roadmend.repair.guard",
    "roadmend.world.runner",
    "roadmend.measures.case_result",
    "roadmend.measures.driving",
)


def identity_of(policy: str, method: str) -> str:
    """Digest of a policy and a repair method: their names, models and code, and the code of the world and the measures.

    Args:
        policy: name or model file.
        method: name, with its default parameters.

    Raises:
        InputError: there is no such policy, model file or method, or a model cannot be read.
    """
    driver, entry = make_policy(policy), METHODS[method]
    made = entry.make(entry.parameters(), 0)
    content = [
        Path(policy).stem,
        getattr(driver, "model_digest", None),
        method,
        getattr(getattr(made, "model", None), "digest", None),
        source_digest([type(driver).__module__, type(made).__module__, *_ALWAYS]),
    ]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()
