"""What a scenario that a search found is called: by the search, and by its number there."""

import re
from collections.abc import Sequence

_TECHNIQUE = r"[A-Za-z0-9_.]*[A-Za-z_][A-Za-z0-9_.]*"  # a registry's label; a number alone is none
_FOUND = re.compile(rf"(?P<search>.+-{_TECHNIQUE}-\d+)-\d{{5,}}")  # ...-TECHNIQUE-SEED-NUMBER


def case_name(labels: Sequence[str], seed: int, index: int) -> str:
    """The name of what a search evaluated.

    Args:
        labels: of what was searched and how; the technique is the last.
        seed: of the search.
        index: number of the evaluation.
    """
    return f"{'-'.join(labels)}-{seed}-{index:05d}"


def search_of(name: str) -> str:
    """The search that found a case, by its ``case_name``: cases of one search are kin.

    What was drawn, or named by somebody, is kin to nobody: it is its own.
    """
    found = _FOUND.fullmatch(name)
    return name if found is None else found["search"]
