"""Runs cases of a corpus again, each in a fresh simulation, to see whether they come to the same."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from pydantic import TypeAdapter

from roadmend.core.fanout import Mapper
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.driver import driver_key
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.search.attempt import Attempt, fault_of
from roadmend.world.corpus import METHOD, Case, told_of
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import outside_content

FORMAT = "roadmend-reruns/2"


_PLAIN = TypeAdapter(Attempt)


def rerun(policy: str, case: Case) -> Attempt:
    """Run a case in this process; an error that it causes is a result here.

    Raises:
        RoadmendError: the machine failed, see ``fault_of``.
    """
    try:
        return Attempt(run_episode(case.scenario(), make_policy(policy), make_repairer(METHOD)), "")
    except Exception as error:  # noqa: BLE001 - see above
        return Attempt(None, fault_of(error))


def agrees(found: Attempt, case: Case) -> bool:
    """Whether an attempt is what the case says."""
    return (found.outcome, found.digest) == (case.outcome, case.digest)


def renewed(case: Case, found: Attempt) -> Case | None:
    """The case with what it comes to now; None where that is another kind of case, or none."""
    result = found.result
    if result is None or result.outcome.name != case.outcome or result.final.at_fault != case.is_violation:
        return None
    return replace(case, **told_of(result))


class Rerunner:
    """Runs cases side by side; keeps what they came to in a journal, so that an interrupted call loses little.

    Errors are not kept: what was wrong may be mended when the case is run again.
    """

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

    def __call__(self, cases: Sequence[Case], report: Callable[[], None] = lambda: None) -> Iterator[Attempt]:
        """One result a case, in order.

        Args:
            cases: what to run.
            report: called for every result.

        Raises:
            InputError: the journal holds something else, or cannot be written.
            RoadmendError: a worker process died, or the machine failed.
        """
        keys = [self._key(case) for case in cases]
        known = [None if self._journal is None else self._journal.get(key) for key in keys]
        missing = [case for case, found in zip(cases, known, strict=True) if found is None]
        results = self._mapper(partial(rerun, self._policy), missing)
        for key, kept in zip(keys, known, strict=True):
            found = next(results) if kept is None else _PLAIN.validate_python(kept)
            if kept is None and found.result is not None and self._journal is not None:
                self._journal.add(key, _PLAIN.dump_python(found, mode="json"))
            report()
            yield found

    def _key(self, case: Case) -> Key:
        scenario = case.scenario().model_copy(update={"name": "point"})
        return entry_key([__name__], self._driver, scenario.digest, outside_content(scenario))
