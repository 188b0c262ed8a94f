"""Tells of violations how persistent they are: whether they come in other futures, too."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from roadmend.core.errors import RoadmendError
from roadmend.core.fanout import Mapper
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.driver import driver_key
from roadmend.measures.need import persistence
from roadmend.policies.registry import make_policy
from roadmend.search.attempt import fault_of
from roadmend.world.corpus import METHOD, Case
from roadmend.world.scenario_file import outside_content

FORMAT = "roadmend-persistence/1"


@dataclass(frozen=True, slots=True)
class _Question:
    case: Case
    policy: str
    count: int


def _answer(question: _Question) -> float | None:
    """Drive the futures in this process; None where an error that the case causes comes in the way.

    Raises:
        RoadmendError: the machine failed, see ``fault_of``.
    """
    case = question.case
    try:
        return persistence(case.scenario(), make_policy(question.policy), case.duration, question.count)
    except RoadmendError as error:
        fault_of(error)
        return None


class PersistenceTeller:
    """Works side by side, and keeps what was found in a journal; of errors nothing is kept."""

    def __init__(self, policy: str, mapper: Mapper, journal: Journal) -> None:
        """Know who drives.

        Args:
            policy: who drives.
            mapper: runs cases side by side.
            journal: where to keep what was found.

        Raises:
            InputError: there is no such policy.
        """
        self._policy, self._mapper, self._journal = policy, mapper, journal
        self._driver = driver_key(policy, METHOD)

    def __call__(
        self, cases: Sequence[Case], count: int, report: Callable[[], None] = lambda: None
    ) -> Iterator[float | None]:
        """The persistence of each case, in order; None of one that is no violation, or whose futures cannot be driven.

        Args:
            cases: violations and others.
            count: futures of each; 0: none is looked at.
            report: called for every case.

        Raises:
            InputError: the journal cannot be written.
            RoadmendError: a worker process died, or the machine failed.
        """
        asked = [case.is_violation and count > 0 for case in cases]
        keys = [self._key(case, count) if ask else None for case, ask in zip(cases, asked, strict=True)]
        known = [None if key is None else self._journal.get(key) for key in keys]
        missing = [
            _Question(case, self._policy, count)
            for case, key, kept in zip(cases, keys, known, strict=True)
            if key is not None and kept is None
        ]
        found = self._mapper(_answer, missing)
        for key, kept in zip(keys, known, strict=True):
            if key is None:
                yield None
            elif kept is None:
                value = next(found)
                if value is not None:
                    self._journal.add(key, {"persistence": value})
                yield value
            else:
                yield kept["persistence"]
            report()

    def _key(self, case: Case, count: int) -> Key:
        scenario = case.scenario().model_copy(update={"name": "point"})
        decided = scenario.digest, outside_content(scenario)
        return entry_key([__name__], self._driver, *decided, case.duration, count)
