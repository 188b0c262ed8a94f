"""Gives each rival its own best setting, found in closed loop on the validation split.

Two rounds: every setting drives a part of the cases, then the best few drive all of them. The best has the largest dE;
of equals the one with the least intensity, of equals again the one that stands first in the grid.
"""

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.training.closed_loop import CaseResult, EpisodeCase, Summary, evaluate_cases, summarise
from roadmend.training.tuning_grid import Rival, Values

FORMAT = "roadmend-tuning/1"
PART = 3  # the first round drives every so many-th case of each family and kind
FINALISTS = 4  # settings that drive all cases


@dataclass(frozen=True, slots=True)
class Point:
    """A setting and what it came to."""

    parameters: Values
    first: Summary  # on a part of the cases
    whole: Summary | None  # on all of them; none for those that the first round left behind

    @property
    def is_finalist(self) -> bool:
        """Whether it has driven all cases."""
        return self.whole is not None


@dataclass(frozen=True, slots=True)
class Tuned:
    """A rival's grid and the best of it."""

    name: str
    method: str
    points: tuple[Point, ...]
    best: int  # index into ``points``

    @property
    def chosen(self) -> Point:
        """The best setting."""
        return self.points[self.best]

    def dump(self) -> dict[str, Any]:
        """As plain values: what was chosen, and the whole grid with its figures."""
        return {
            "method": self.method,
            "parameters": dict(self.chosen.parameters),
            "figures": _figures(self.chosen.whole),
            "grid": [
                {"parameters": dict(point.parameters), "part": _figures(point.first), "all": _figures(point.whole)}
                for point in self.points
            ],
        }


def worth(summary: Summary) -> tuple[float, float]:
    """The larger, the better: dE, then the intensity turned round."""
    return round(summary.delta_e, 9), -summary.intensity


def part_of(cases: Sequence[EpisodeCase]) -> list[EpisodeCase]:
    """Every PART-th case of each family and kind, the first one included, in the order of the cases."""
    seen: dict[tuple[str, bool], int] = {}
    chosen: list[EpisodeCase] = []
    for case in cases:
        key = case.family, case.is_violation
        if seen.get(key, 0) % PART == 0:
            chosen.append(case)
        seen[key] = seen.get(key, 0) + 1
    return chosen


class Tuning:
    """Drives settings on cases, each pair at most once: what was driven before an interruption is in ``file``."""

    def __init__(
        self,
        cases: Sequence[EpisodeCase],
        policy: str,
        identity: Mapping[str, str],
        file: Path,
        mapper: Mapper,
        report: Callable[[str, int, int], None] = lambda _rival, _done, _total: None,
    ) -> None:
        """Open or make the file.

        Args:
            cases: of the validation split; with violations and successes.
            policy: name of the policy in the loop.
            identity: digests of all that the results hang on; a file keeps to one set of them.
            file: JSON lines, one for each episode.
            mapper: runs episodes side by side.
            report: called with the rival, the episodes driven and how many there are in this round.

        Raises:
            InputError: a kind of case is missing, or the file is of other cases, damaged or cannot be written.
        """
        for wanted, word in ((True, "violation"), (False, "success")):
            if not any(case.is_violation == wanted for case in cases):
                raise InputError("validation split", f"has no {word}", "give a corpus with both in it")
        self._cases, self._policy, self._file = list(cases), policy, file
        self._mapper, self._report = mapper, report
        self._known: dict[tuple[str, str], CaseResult] = {}
        self._open({"format": FORMAT, "policy": policy, **identity})

    def tune(self, rival: Rival) -> Tuned:
        """Find a rival's best setting.

        Raises:
            InputError: a parameter or a scenario is unusable.
            SimulationError: SUMO failed, or a worker process died.
        """
        part = part_of(self._cases)
        first = self._drive(rival, rival.grid, part)
        ranked = sorted(range(len(first)), key=lambda index: worth(first[index]), reverse=True)
        finalists = ranked[:FINALISTS]
        driven = self._drive(rival, [rival.grid[index] for index in finalists], self._cases)
        whole = dict(zip(finalists, driven, strict=True))
        best = max(sorted(whole), key=lambda index: worth(whole[index]))
        points = (Point(parameters, first[index], whole.get(index)) for index, parameters in enumerate(rival.grid))
        return Tuned(rival.name, rival.method, tuple(points), best)

    def _drive(self, rival: Rival, grid: Sequence[Values], cases: Sequence[EpisodeCase]) -> list[Summary]:
        """One summary a setting."""
        keys = [_key(rival.method, parameters) for parameters in grid]
        missing = [
            (key, parameters, case)
            for key, parameters in zip(keys, grid, strict=True)
            for case in cases
            if (key, case.name) not in self._known
        ]
        total = len(grid) * len(cases)
        done = total - len(missing)
        self._report(rival.name, done, total)
        for (key, _, case), result in zip(missing, self._results(rival.method, missing), strict=True):
            self._write({"setting": key, "result": asdict(result)})
            self._known[key, case.name] = result
            done += 1
            self._report(rival.name, done, total)
        return [summarise([self._known[key, case.name] for case in cases]) for key in keys]

    def _results(self, method: str, missing: Sequence[tuple[str, Values, EpisodeCase]]) -> Iterator[CaseResult]:
        questions = [(parameters, case) for _, parameters, case in missing]
        return self._mapper(partial(_evaluate, policy=self._policy, method=method), questions)

    def _open(self, header: dict[str, Any]) -> None:
        path = self._file
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_bytes() if path.exists() else b""
            whole = content[: content.rfind(b"\n") + 1]
            if len(whole) < len(content):
                os.truncate(path, len(whole))  # an interruption cut the last line short
        except OSError as error:
            raise InputError(str(path), f"cannot be read ({error.strerror})", "choose another place") from None
        if not whole:
            self._write(header)
            return
        lines = whole.decode(errors="replace").splitlines()
        try:
            if json.loads(lines[0]) != header:
                raise InputError(str(path), "holds another tuning", "remove it, or choose another --out")
            for line in lines[1:]:
                entry = json.loads(line)
                result = CaseResult(**entry["result"])
                self._known[entry["setting"], result.name] = result
        except (ValueError, KeyError, TypeError):
            raise InputError(str(path), "is damaged", "remove it") from None

    def _write(self, values: dict[str, Any]) -> None:
        try:
            with self._file.open("ab", buffering=0) as file:
                file.write(json.dumps(values).encode() + b"\n")
        except OSError as error:
            raise InputError(str(self._file), f"cannot be written ({error.strerror})", "make room") from None


def _evaluate(question: tuple[Values, EpisodeCase], *, policy: str, method: str) -> CaseResult:
    parameters, case = question
    return evaluate_cases([case], policy, method, parameters)[0]


def _key(method: str, parameters: Values) -> str:
    return f"{method} {json.dumps(dict(parameters), sort_keys=True)}"


def _figures(summary: Summary | None) -> dict[str, float] | None:
    return None if summary is None else {name: round(value, 4) for name, value in summary.as_dict().items()}
