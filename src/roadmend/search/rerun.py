"""Runs cases of a corpus again, each in a fresh simulation, to see whether they come to the same."""

import fcntl
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.outcome import Blame
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.search.evaluation import CRASH
from roadmend.search.policy_model import policy_model
from roadmend.world.corpus import METHOD, Case
from roadmend.world.runner import run_episode


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
    distance = summary.min_distance if math.isfinite(summary.min_distance) else None
    final = summary.events[-1]
    return Rerun(
        summary.outcome.name,
        summary.digest,
        summary.text,
        distance,
        summary.duration,
        final.blame.name,
        final.object_kinds[0].name.lower() if final.object_kinds else "",
        None if final.impact_speed is None else round(final.impact_speed, 1),
    )


class Rerunner:
    """Runs cases side by side; keeps what they came to in a file, so that an interrupted call loses little.

    The file serves one process at a time. Its lines hold for one version of roadmend and one model of the policy.
    """

    def __init__(self, policy: str, mapper: Mapper, file: Path | None = None) -> None:
        """Open the file.

        Args:
            policy: who drives.
            mapper: runs cases side by side.
            file: where to keep results; nowhere if not given.

        Raises:
            InputError: there is no such policy, or the file is in use or cannot be written.
        """
        self._policy, self._mapper = policy, mapper
        self._identity = f"{__version__} {policy} {policy_model(policy)}"
        self._known: dict[str, Rerun] = {}
        with ExitStack() as stack:
            self._file = None if file is None else stack.enter_context(_open(file))
            if self._file is not None:
                self._known = _read(self._file)
            self._stack = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, traceback)

    def __call__(self, cases: Sequence[Case], report: Callable[[], None] = lambda: None) -> Iterator[Rerun]:
        """One result a case, in order.

        Args:
            cases: what to run.
            report: called for every result.

        Raises:
            SimulationError: a worker process died.
        """
        keys = [self._key(case) for case in cases]
        known = [self._known.get(key) for key in keys]
        missing = [case for case, found in zip(cases, known, strict=True) if found is None]
        results = self._mapper(partial(rerun, self._policy), missing)
        for key, kept in zip(keys, known, strict=True):
            found = kept or next(results)
            if kept is None and self._file is not None:
                self._known[key] = found
                self._file.write(json.dumps({"key": key, **asdict(found)}).encode() + b"\n")
            report()
            yield found

    def _key(self, case: Case) -> str:
        content = f"{self._identity} {case.scenario().model_copy(update={'name': 'point'}).digest}"
        return hashlib.sha256(content.encode()).hexdigest()


def _open(path: Path) -> Any:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("a+b", buffering=0)
    except OSError as error:
        raise InputError(str(path), f"cannot be written ({error.strerror})", "choose a writable folder") from None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise InputError(str(path.parent), "another build is at work here", "wait for it to end") from None
    return file


def _read(file: Any) -> dict[str, Rerun]:
    """Lines that are whole; one that an interruption cut short, and all after it, are forgotten."""
    file.seek(0)
    content: bytes = file.readall()
    known: dict[str, Rerun] = {}
    sound = 0
    for line in content.splitlines(keepends=True):
        try:
            entry = json.loads(line)
            if not line.endswith(b"\n"):
                break
            key = entry.pop("key")
            known[key] = Rerun(**entry)
        except (ValueError, TypeError, KeyError, AttributeError):
            break
        sound += len(line)
    file.truncate(sound)
    return known
