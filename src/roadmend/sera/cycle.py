"""Generations of a policy: it drives, its failures are analysed, scenarios recommended, it is tuned, and drives again.

Every step leaves a file in the folder of its generation, with a key of all that decided it: an interrupted cycle goes on
with the first step whose file is missing or has another key.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from roadmend.core.errors import InputError
from roadmend.core.journal import entry_key
from roadmend.core.json_text import read_json
from roadmend.core.whole_file import write_text
from roadmend.language.exchange import ENDING
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.summary import summarise
from roadmend.sera.analysis import BagAnalysis, analyse
from roadmend.sera.analysis_report import NOTHING, report
from roadmend.sera.backends import Backend
from roadmend.sera.bank import Bank
from roadmend.sera.pattern import PATTERNS, FailurePattern, parse_patterns
from roadmend.sera.recommendation import content_of, recommend, shares
from roadmend.world.scenario import Scenario


@dataclass(frozen=True, slots=True)
class PolicyEvaluation:
    """What a policy made of the evaluation set."""

    measures: tuple[DrivingMeasures, ...]
    bags: tuple[Path, ...]  # of what went wrong
    faults: tuple[str, ...] = ()  # episodes that could not be driven, and why


@dataclass(frozen=True, slots=True)
class TunedPolicy:
    """What tuning came to."""

    model: Path
    epochs: int  # that were kept; 0 where none was better than the policy as it was
    driving_score: float | None  # on the validation set; None where that was not driven
    before: float | None  # likewise, of the policy as it was


class Steps(Protocol):
    """What a cycle has others do."""

    def identity(self, policy: str) -> str:
        """A digest of the policy, and of what it is tuned with beside scenarios and settings."""

    def evaluate(self, policy: str) -> PolicyEvaluation:
        """Drive the evaluation set; quick where that has been done."""

    def read(self, bags: Sequence[Path]) -> Iterable[BagAnalysis]:
        """The incidents of bags, in order."""

    def tune(self, policy: str, scenarios: Sequence[Scenario], selection: str, out: Path) -> TunedPolicy:
        """Tune a policy on scenarios, of the selection with this digest, into a new model file."""


@dataclass(frozen=True, slots=True)
class CycleOptions:
    """How a cycle goes."""

    generations: int = 2  # times that the policy is tuned
    scenarios: int = 24  # that are learned from in a generation, shared among the patterns by their evidence
    seed: int = 0
    first_bags: tuple[Path, ...] = ()  # that are learned from in the first generation instead of the evaluation's
    settings: str = ""  # of the tuning and of the backend, as text: what they decide is done again when they change


@dataclass(frozen=True, slots=True)
class Generation:
    """A policy, what it came to, and what was learned from that."""

    number: int
    policy: str
    summary: dict[str, Any]  # the four measures, see ``summarise``
    failures: int = 0  # bags of the evaluation
    faults: tuple[str, ...] = ()
    incidents: int = 0  # in the bags that were learned from
    patterns: tuple[str, ...] = ()  # in words
    selected: tuple[str, ...] = ()  # names of the scenarios
    swaps: int = 0
    tuned: TunedPolicy | None = None
    notes: tuple[str, ...] = ()


class Cycle:
    """Runs the generations of one folder.

    Args:
        bank: that is recommended from.
        backend: that analyses and reflects.
        steps: what others do.
        excluded: digests of the scenarios of the evaluation set, which are never learned from.
        folder: for everything that is kept.
        options: see ``CycleOptions``.
        report: hears what is being done.
    """

    def __init__(
        self,
        bank: Bank,
        backend: Backend,
        steps: Steps,
        excluded: Sequence[str],
        folder: Path,
        options: CycleOptions,
        report: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._bank = bank
        self._backend = backend
        self._steps = steps
        self._excluded = [*excluded]
        self._folder = folder
        self._options = options
        self._report = report
        self._is_resumed = False  # whether a step of the generation came out of its file

    def run(self, policy: str) -> Iterator[Generation]:
        """The generations, each as soon as it is known; fewer than asked for where there is nothing more to learn.

        Args:
            policy: name or model file of a neural policy.

        Raises:
            InputError: a place cannot be written, or a step was given something unusable.
            LanguageError: the backend asks a language model, and no usable answer came.
            SimulationError: SUMO failed, or a worker process died.
        """
        bags = self._options.first_bags
        for number in range(self._options.generations + 1):
            self._report(f"generation {number}: driving")
            found = self._steps.evaluate(policy)
            generation = Generation(number, policy, summarise(found.measures), len(found.bags), found.faults)
            if number < self._options.generations:
                generation = self._learn(generation, bags or found.bags)
            yield generation
            if generation.tuned is None:
                return
            if generation.tuned.epochs:
                policy = str(generation.tuned.model)
            bags = ()

    def _learn(self, generation: Generation, bags: Sequence[Path]) -> Generation:
        folder = self._folder / f"generation-{generation.number}"
        self._is_resumed = False
        is_done = False
        try:
            learned = self._learned(generation, bags, folder)
            is_done = True
            return learned
        finally:
            self._backend.keep(folder / f"language{ENDING}", adding=self._is_resumed or not is_done)
            if self._backend.model is not None:
                self._backend.model.exchanges.clear()

    def _learned(self, generation: Generation, bags: Sequence[Path], folder: Path) -> Generation:
        self._report(f"generation {generation.number}: analysing")
        analysis = self._step(
            folder / "analysis.json",
            [self._options.settings, *map(_bag_key, bags)],
            lambda: self._analyse(bags, folder),
        )
        patterns = parse_patterns(analysis["patterns"], str(folder / "analysis.json"))
        known, notes = self._known(patterns)
        notes = [*(f"not read: {each}" for each in analysis["unreadable"]), *notes]
        generation = replace(
            generation,
            incidents=analysis["incidents"],
            patterns=tuple(each.words for each in patterns),
            notes=tuple(notes if patterns else [*notes, NOTHING]),
        )
        if not known:
            return generation
        self._report(f"generation {generation.number}: recommending")
        exclude = [*self._excluded, *self._selected_before(generation.number)]
        path = folder / "recommendation.json"
        content = self._step(
            path,
            [
                self._options.settings,
                self._bank.digest,
                PATTERNS.dump_python(known, mode="json"),
                self._options.scenarios,
                self._options.seed,
                exclude,
            ],
            lambda: self._recommend(known, exclude),
        )
        entries = [self._bank.find(each["digest"]) for each in content["refined"]]
        if None in entries:
            missing = content["refined"][entries.index(None)]["name"]
            raise InputError(str(path), f"{missing} is not in {self._bank.path}", "remove the file to choose anew")
        usable = [entry.scenario for entry in entries if entry is not None and entry.scenario is not None]
        generation = replace(
            generation, selected=tuple(each["name"] for each in content["refined"]), swaps=len(content["swaps"])
        )
        if not usable:
            return _noted(generation, "the bank has no scenario that can be driven and was not learned from before")
        return self._tuned(generation, usable, path, folder)

    def _tuned(
        self, generation: Generation, scenarios: Sequence[Scenario], selection: Path, folder: Path
    ) -> Generation:
        self._report(f"generation {generation.number}: tuning on {len(scenarios)} scenarios")
        model = folder / "model.safetensors"
        digest = _digest(selection.read_text(encoding="utf-8"))

        def tune() -> dict[str, Any]:
            tuned = self._steps.tune(generation.policy, scenarios, digest, model)
            return {"epochs": tuned.epochs, "driving_score": tuned.driving_score, "before": tuned.before}

        decided = [self._options.settings, self._steps.identity(generation.policy), digest, self._options.seed]
        content = self._step(folder / "tuning.json", decided, tune, needed=model)
        tuned = TunedPolicy(model, content["epochs"], content["driving_score"], content["before"])
        generation = replace(generation, tuned=tuned)
        if not tuned.epochs:
            return _noted(generation, "no epoch was better than the policy as it was, which goes on unchanged")
        return generation

    def _analyse(self, bags: Sequence[Path], folder: Path) -> dict[str, Any]:
        analysis = analyse([*self._steps.read(bags)], self._backend.analyser)
        write_text(folder / "analysis.md", report(analysis))
        return {
            "bags": list(analysis.bags),
            "unreadable": [each.problem for each in analysis.unreadable],
            "incidents": len(analysis.incidents),
            "patterns": PATTERNS.dump_python([*analysis.patterns], mode="json", exclude_defaults=True),
        }

    def _recommend(self, patterns: Sequence[FailurePattern], exclude: Sequence[str]) -> dict[str, Any]:
        options = self._options
        found = recommend(
            self._bank,
            patterns,
            shares(patterns, options.scenarios),
            exclude=exclude,
            seed=options.seed,
            reflector=self._backend.reflector,
        )
        return content_of(found, patterns, self._bank)

    def _known(self, patterns: Sequence[FailurePattern]) -> tuple[list[FailurePattern], list[str]]:
        """Patterns that say something to the bank, and notes on the others."""
        known, notes = [], list[str]()
        for pattern in patterns:
            try:
                self._bank.embed(pattern)
            except InputError as error:
                notes.append(f"left out: {error}")
            else:
                known.append(pattern)
        return known, notes

    def _selected_before(self, number: int) -> list[str]:
        """Digests of what earlier generations have learned from: a generation takes what is new."""
        found: list[str] = []
        for earlier in range(number):
            path = self._folder / f"generation-{earlier}" / "recommendation.json"
            content = read_json(path)
            found += [each["digest"] for each in content["refined"]]
        return found

    def _step(
        self, path: Path, decided: Sequence[Any], make: Callable[[], dict[str, Any]], needed: Path | None = None
    ) -> dict[str, Any]:
        """What a step came to: out of its file, or made now.

        Args:
            path: of the file.
            decided: all that decided it, as plain data.
            make: does the step.
            needed: another file that it leaves.
        """
        backend = self._backend
        code = [__name__, type(backend.analyser).__module__, type(backend.reflector).__module__]
        model = getattr(getattr(backend.model, "model", None), "identity", "")
        key = entry_key(code, path.name, model, *decided)
        try:
            content: dict[str, Any] = read_json(path)
            if content["key"] == key and (needed is None or needed.exists()):
                self._is_resumed = True
                return content
        except (InputError, KeyError, TypeError):
            pass  # not done, or not to the end
        content = {"key": key, **make()}
        write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n")
        return content


def _noted(generation: Generation, note: str) -> Generation:
    return replace(generation, notes=(*generation.notes, note))


def _bag_key(bag: Path) -> list[Any]:
    """The bag's place and what is in it, by the sizes of its files."""
    files = sorted(bag.iterdir()) if bag.is_dir() else [bag]
    return [str(bag), [file.stat().st_size for file in files if file.is_file()]]


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
