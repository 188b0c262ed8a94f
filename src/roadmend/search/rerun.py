"""Runs cases of a corpus again, each in a fresh simulation, to see whether they come to the same."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial

from roadmend.core.fanout import Mapper
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.core.outcome import Blame
from roadmend.measures.driver import driver_key
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.search.evaluation import CRASH
from roadmend.world.corpus import METHOD, Case
from roadmend.world.runner import run_episode

FORMAT = "roadmend-reruns/1"


@dataclass(frozen=True, slots=True)
class Rerun:
    """What a case came to."""

    outcome: str  # an EventKind's name, or CRASH
    digest: str  # of the trajectory; empty after a crash
    text: str
    min_distance: float | None  # [m]
    duration: float  # [s] simulation time
    blame: str = Blame.UNKNOWN.name  # of a collision
    partner: str = ""  # in a collision, by kind
    impact_speed: float | None = None  # [m/s] at a collision, to a tenth

    def agrees(self, case: Case) -> bool:
        """Whether it is what the case says."""
        return (self.outcome, self.digest) == (case.outcome, case.digest)

    def complete(self, case: Case) -> Case:
        """The case with what only a run can tell."""
        told = {name: value for name, value in asdict(self).items() if name not in {"outcome", "digest"}}
        return replace(case, **told)


def rerun(policy: str, case: Case) -> Rerun:
    """Run a case in this process; an error on the way is a result here."""
    try:
        summary = run_episode(case.scenario(), make_policy(policy), make_repairer(METHOD))
    except Exception as error:  # noqa: BLE001 - see above
        return Rerun(CRASH, "", " ".join(f"{type(error).__name__}: {error}".split()), None, 0.0)
    final = summary.final
    return Rerun(
        summary.outcome.name,
        summary.digest,
        summary.text,
        summary.min_distance,
        summary.duration,
        final.blame.name,
        final.object_kinds[0].name.lower() if final.object_kinds else "",
        None if final.impact_speed is None else round(final.impact_speed, 1),
    )


class Rerunner:
    """Runs cases side by side; keeps what they came to in a journal, so that an interrupted call loses little."""

    def __init__(self, policy: str, mapper: Mapper, journal: Journal | None = None) -> None:
        """Know who drives.

        Args:
            policy: who drives.
            mapper: runs cases side by side.
            journal: where to keep results; nowhere if not given.

        Raises:
            InputError: there is no such policy.
        """
        self._policy, self._mapper, self._journal = policy, mapper, journal
        self._driver = driver_key(policy, METHOD)

    def __call__(self, cases: Sequence[Case], report: Callable[[], None] = lambda: None) -> Iterator[Rerun]:
        """One result a case, in order.

        Args:
            cases: what to run.
            report: called for every result.

        Raises:
            InputError: the journal holds something else, or cannot be written.
            SimulationError: a worker process died.
        """
        keys = [self._key(case) for case in cases]
        known = [None if self._journal is None else self._journal.get(key) for key in keys]
        missing = [case for case, found in zip(cases, known, strict=True) if found is None]
        results = self._mapper(partial(rerun, self._policy), missing)
        for key, kept in zip(keys, known, strict=True):
            found = next(results) if kept is None else Rerun(**kept)
            if kept is None and self._journal is not None:
                self._journal.add(key, asdict(found))
            report()
            yield found

    def _key(self, case: Case) -> Key:
        scenario = case.scenario().model_copy(update={"name": "point"})
        return entry_key([__name__], self._driver, scenario.digest)
