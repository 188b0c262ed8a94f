"""Which jobs there are for a number of crashes.

Apart from the jobs themselves, so that what decides a job's result is not how its report was read.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

from roadmend.safe.cases import Case
from roadmend.safe.construction import Role
from roadmend.safe.driving import Drawing, Job, Task


def plan(
    task: Task,
    cases: Iterable[Case],
    policies: Sequence[str],
    out: Path,
    *,
    samples: int = 1,
    budget: int = 0,
    seed: int = 0,
    draw: Drawing | None = None,
) -> list[Job]:
    """The jobs: every vehicle of every case takes the ego's place in turn."""
    return [
        Job(task, Role(case.name, case.crash, ego), policy, seed, index, budget, out, draw)
        for policy in policies
        for case in cases
        if case.crash is not None
        for ego in range(len(case.crash.vehicles))
        for index in range(samples)
    ]
