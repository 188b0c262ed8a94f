"""Cases from searches that nothing else uses, for the benchmarks, with the search's progress told."""

from collections.abc import Sequence
from pathlib import Path

from rich.progress import Progress

from roadmend.search.gather import Progress as Stage
from roadmend.search.gather import gather_fresh
from roadmend.world.corpus import Corpus
from roadmend.world.families import FAMILIES


def fresh_cases(
    policy: str,
    seed: int,
    cases: int,
    work: Path,
    workers: int,
    progress: Progress,
    families: Sequence[str] = tuple(FAMILIES),
) -> Corpus:
    """Gather a policy's test set with a seed of its own; searches that ``work`` holds already are not repeated.

    Args:
        policy: who drives.
        seed: of the searches.
        cases: violations, and as many successes, of each family; what could not be found is printed.
        work: the benchmark's kept folder; the searches are in fresh/ below it.
        workers: processes.
        progress: where a task tells how far it is.
        families: of which scenarios.

    Raises:
        InputError: there is no such policy or family, or a folder holds another search, is in use or cannot be written.
        SimulationError: a worker process died.
    """
    task = progress.add_task(f"{policy}: fresh cases", total=None)

    def report(stage: Stage) -> None:
        text = f"{policy}: {stage.stage} {stage.done}/{stage.total}, {stage.accepted} of {stage.wanted} fresh cases"
        progress.update(task, description=text, completed=stage.accepted, total=stage.wanted)

    gathered = gather_fresh(policy, seed, cases, work / "fresh", workers, report, families=families)
    for shortage in gathered.shortages:
        progress.console.print(f"{policy}: {shortage}")
    return gathered.corpus
