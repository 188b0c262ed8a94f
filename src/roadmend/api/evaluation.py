"""Policies times repair methods times scenarios, measured; of one's own or by name."""

import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from roadmend.api.given import PolicyLike, RepairLike, name_of, policy_of, repairer_of, title_of
from roadmend.api.scenarios import ScenarioLike, scenarios_of
from roadmend.core.errors import InputError
from roadmend.core.extras import extra_missing
from roadmend.core.journal import Journal, Key
from roadmend.core.markdown import table_text
from roadmend.core.whole_number import whole_number
from roadmend.measures.driver import driver_key
from roadmend.measures.evaluation import FORMAT, TRIVIAL, Driven, EvaluationTrial, drive_with, run_trials, seed_of
from roadmend.measures.evaluation_figures import TITLE, evaluation_rows, meanings
from roadmend.measures.evaluation_figures import evaluate as figures_of
from roadmend.measures.fitting import fitting, fitting_accounts
from roadmend.reports.result_files import provenance, write_report

if TYPE_CHECKING:
    import pandas as pd

Progress = Callable[[int, int], None]  # of how many are done, of how many
Given = TypeVar("Given")


@dataclass(frozen=True, slots=True)
class EvaluationReport:
    """What came of it. Printed, it is the table of ``roadmend evaluate`` in Markdown.

    Attributes:
        figures: every measure, as plain values, by policy and repair method.
        driven: the episodes, each with what it came to or why there is nothing.
        fitting: by policy and repair method, in a line, which model and settings the method ran with, where both have
            names.
    """

    figures: dict[str, dict[str, dict[str, Any]]]
    driven: tuple[Driven, ...]
    fitting: dict[str, dict[str, str]] = field(default_factory=dict)

    @property
    def rows(self) -> list[list[str]]:
        """The table as texts, its heading first."""
        return evaluation_rows(self.figures)

    @property
    def faults(self) -> list[str]:
        """Why episodes could not be driven, one line each."""
        return [each.fault for each in self.driven if each.fault]

    def __str__(self) -> str:
        return "\n".join([table_text(self.rows), *self.faults])

    @property
    def episodes(self) -> "pd.DataFrame":
        """One row an episode: policy, method, scenario, outcome and figures; times [s], distances [m].

        Raises:
            InputError: pandas is not installed.
        """
        try:
            import pandas as pd  # noqa: PLC0415 - only who asks for such a table needs it
        except ModuleNotFoundError as error:
            raise extra_missing(error) from None
        return pd.DataFrame(self._plain())

    def save(self, folder: str | PathLike[str]) -> Path:
        """Write evaluation.json, evaluation.md and evaluation.html; returns the path of the page.

        Raises:
            InputError: the folder cannot be written, or what draws pages is not installed; the other two files are there
                then.
        """
        made = provenance(f"python {Path(sys.argv[0]).name or '-'}")
        self.write(Path(folder), self.content(made))
        try:
            return self.write_page(Path(folder), made)
        except ModuleNotFoundError as error:
            raise extra_missing(error) from None

    def content(self, made: Mapping[str, Any]) -> dict[str, Any]:
        """What evaluation.json holds, as plain values; ``made`` says by what it was made, see ``reports.result_files``."""
        return {
            "provenance": made,
            "policies": self.figures,
            "fitting": self.fitting,
            "faults": self.faults,
            "episodes": self._plain(),
        }

    def write(self, folder: Path, content: Mapping[str, Any], more: Sequence[Sequence[str]] = ()) -> None:
        """Write evaluation.json and evaluation.md, with a second table where there is one.

        Raises:
            InputError: the folder cannot be written.
        """
        write_report(folder, "evaluation", TITLE, content, self.rows, more)

    def write_page(self, folder: Path, made: Mapping[str, Any]) -> Path:
        """Write evaluation.html; returns its path.

        Raises:
            InputError: the folder cannot be written.
            ModuleNotFoundError: what draws pages is not installed.
        """
        from roadmend.reports.evaluation_page import write_page  # noqa: PLC0415 - needs the extra

        return write_page(folder, TITLE, self.rows, meanings().split("; "), self._plain(), self.faults, made)

    def _plain(self) -> list[dict[str, Any]]:
        return [
            {**each.result.figures(), "policy": each.trial.policy, "method": each.trial.method}
            for each in self.driven
            if each.result is not None
        ]


def evaluate(
    scenarios: ScenarioLike | Sequence[ScenarioLike],
    policies: PolicyLike | Sequence[PolicyLike] = "modular",
    repairs: RepairLike | Sequence[RepairLike] = "adreft",
    *,
    workers: int = 1,
    futures: int = 0,
    folder: str | PathLike[str] | None = None,
    progress: Progress | None = None,
) -> EvaluationReport:
    """Drive every policy with every repair method in every scenario, and tell what they are worth.

    Every policy is driven alone and with random repair too: what it collides in alone can be fixed, what it completes
    can be degraded. An episode that fails is a line of ``faults``, and the others go on. Classes that stand in a file
    are made anew for each episode, in worker processes where there are several: a script that asks for workers must
    stand under ``if __name__ == "__main__":``. Objects, and classes of a notebook, are driven in this process one
    after the other, and their episodes are not kept.

    Args:
        scenarios: or paths of their files.
        policies: names, classes or objects.
        repairs: names, classes or objects.
        workers: processes, from 1; what comes out does not depend on their number.
        futures: from 0, by which it is told whether each intervention was needed; 0 leaves it untold.
        folder: in which finished episodes are kept, so that they are not driven again; none keeps nothing.
        progress: hears how many of how many episodes are done.

    Raises:
        InputError: an argument is unusable.
        SimulationError: a worker process died.
    """
    chosen = scenarios_of(scenarios)
    workers, futures = whole_number("workers", workers, 1), whole_number("futures", futures)
    drivers: list[PolicyLike] = _several(policies, "policies")
    if not drivers:
        raise InputError("policies", "there is none", "give one at least")
    asked: list[RepairLike] = _several(repairs, "repairs")
    methods: list[RepairLike] = [*TRIVIAL, *(each for each in asked if title_of(each) not in TRIVIAL)]
    pairs = [*product(drivers, methods)]
    named = {place: _key(*pair) for place, pair in enumerate(pairs)}
    for driver, method in pairs:  # refused before anything is driven
        policy_of(driver)
        repairer_of(method)
    accounts = fitting_accounts(*([*filter(None, map(name_of, given))] for given in (drivers, asked)))
    trials = [
        [
            EvaluationTrial(
                each, _name(driver), _name(method), named[place] or Key(""), futures, _fitted(driver, method)
            )
            for each in chosen
        ]
        for place, (driver, method) in enumerate(pairs)
    ]
    kept = [trial for place, several in enumerate(trials) if named[place] is not None for trial in several]
    total, tell = len(pairs) * len(chosen), progress or (lambda _done, _all: None)
    with ExitStack() as stack:
        keep = folder if folder is not None else stack.enter_context(tempfile.TemporaryDirectory())
        journal = stack.enter_context(Journal(Path(keep) / "results.jsonl", FORMAT, owns_folder=True))
        answers = iter(run_trials(kept, journal, workers, lambda done: tell(done, total)))
    driven: list[Driven] = []
    here = len(kept)
    for number, (driver, method) in enumerate(pairs):
        for trial in trials[number]:
            if named[number] is not None:
                driven.append(next(answers))
            else:
                driven.append(_drive_here(trial, driver, method))
                here += 1
                tell(here, total)
    return EvaluationReport(figures_of(driven), tuple(driven), accounts)


def _several(given: Given | Sequence[Given], where: str) -> list[Given]:
    """One, or several in a row.

    Raises:
        InputError: two are called alike, so that no table could tell them apart.
    """
    found: list[Given] = [*given] if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    titles = [title_of(each) for each in found]
    twice = next((title for title in titles if titles.count(title) > 1), None)
    if twice is not None:
        raise InputError(where, f"two are called {twice!r}", "give each a class of its own, or evaluate them apart")
    return found


def _name(given: object) -> str:
    return name_of(given) or title_of(given)


def _key(driver: PolicyLike, method: RepairLike) -> Key | None:
    """Of kept episodes; None where one of the two is found in this process alone."""
    names = name_of(driver), name_of(method)
    return driver_key(*names, _fitted(driver, method)) if all(names) else None


def _fitted(driver: PolicyLike, method: RepairLike) -> dict[str, Any]:
    """The model and the settings that were made for the policy, as ``roadmend evaluate`` takes them."""
    names = name_of(driver), name_of(method)
    return fitting(names[1], names[0]) if all(names) and names[1] not in TRIVIAL else {}


def _drive_here(trial: EvaluationTrial, driver: PolicyLike, method: RepairLike) -> Driven:
    seed = seed_of(trial.scenario.name)
    return drive_with(trial, partial(policy_of, driver), partial(repairer_of, method, None, seed))
