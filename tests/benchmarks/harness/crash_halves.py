"""Which crash reports rules are developed on, and which are only measured: a committed split by a committed seed."""

import random
from collections.abc import Sequence
from pathlib import Path

import yaml

from roadmend.core.errors import InputError

HALVES = ("seen", "unseen")
SEED = "crash reports 2026"
SEEN = 28  # of them
_FILE = Path(__file__).parents[1] / "crash_halves.yaml"


def load_halves(path: Path = _FILE) -> dict[str, frozenset[str]]:
    """The names of either half.

    Raises:
        InputError: the file does not have the two halves, or a name is in both.
    """
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or {*content} != {*HALVES}:
        raise InputError(str(path), "does not have the two halves", f"give {' and '.join(HALVES)}")
    halves = {name: frozenset(map(str, content[name])) for name in HALVES}
    both = halves["seen"] & halves["unseen"]
    if both:
        raise InputError(str(path), f"{min(both)} is in both halves", "keep each report in one")
    return halves


def split(names: Sequence[str]) -> dict[str, list[str]]:
    """The split that the file holds, made anew."""
    shuffled = sorted(names)
    random.Random(SEED).shuffle(shuffled)
    return {"seen": sorted(shuffled[:SEEN]), "unseen": sorted(shuffled[SEEN:])}
