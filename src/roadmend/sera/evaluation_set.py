"""What a policy is evaluated on, and that none of it is what it learns from."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from roadmend.core.bounded_file import open_regular
from roadmend.core.errors import InputError
from roadmend.sera.near_equality import content_digest
from roadmend.world.corpus import load_corpus
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import load_scenario

_SQLITE = b"SQLite format 3\0"
_SCENARIOS = frozenset({".yaml", ".yml"})


@dataclass(frozen=True, slots=True)
class Known:
    """Digests of scenarios: as they are, and without their names, since a name changes nothing."""

    digests: frozenset[str] = frozenset()
    contents: frozenset[str] = frozenset()

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], digests: Iterable[str] = ()) -> Self:
        """Some scenarios, and others of which only the digests are there."""
        return cls(
            frozenset({*digests, *(scenario.digest for scenario in scenarios)}),
            frozenset(content_digest(scenario) for scenario in scenarios),
        )

    def holds(self, scenario: Scenario) -> bool:
        """Whether the scenario is among them, under whatever name."""
        return scenario.digest in self.digests or content_digest(scenario) in self.contents


def sampled_set(count: int, first_seed: int) -> list[Scenario]:
    """Random scenarios, ``count`` of each family."""
    return [sample_scenario(family, first_seed + number) for family in FAMILIES for number in range(count)]


def corpus_set(path: Path, split: str | None) -> list[Scenario]:
    """The scenarios of a corpus, of one split or all.

    Raises:
        InputError: the file is no corpus.
    """
    return [case.scenario() for case in load_corpus(path).select(split=split)]


def chosen_set(scenarios: int | None, first_seed: int | None, corpus: Path | None, split: str | None) -> list[Scenario]:
    """The evaluation set that the options stand for.

    Raises:
        InputError: they contradict each other, or the file is no corpus.
    """
    if corpus is None:
        if split is not None:
            raise InputError("--split", "is of a corpus, and there is none", "name one with --corpus")
        return sampled_set(20 if scenarios is None else scenarios, first_seed or 0)
    if scenarios is not None or first_seed is not None:
        raise InputError("--corpus", "leaves nothing to draw", "give either --corpus or --scenarios and --first-seed")
    return corpus_set(corpus, split)


def known_in(paths: Iterable[Path]) -> Known:
    """The scenarios of banks, corpora and scenario files.

    Raises:
        InputError: a file is missing or none of these.
    """
    digests, scenarios = set[str](), list[Scenario]()
    for path in paths:
        if _is_bank(path):
            from roadmend.sera.bank import Bank  # noqa: PLC0415 - its index is slow to import, and most runs name none

            with Bank(path) as bank:
                for entry in bank.entries():
                    digests.add(entry.digest)
                    scenarios += [] if entry.scenario is None else [entry.scenario]
        elif path.suffix.lower() in _SCENARIOS:
            scenarios.append(load_scenario(path))
        else:
            scenarios += corpus_set(path, None)
    return Known.of(scenarios, digests)


def disjoint(scenarios: Sequence[Scenario], known: Known) -> list[Scenario]:
    """Those that are not known.

    Raises:
        InputError: nothing is left.
    """
    left = [scenario for scenario in scenarios if not known.holds(scenario)]
    if not left:
        raise InputError(
            "the evaluation set", "holds no scenario that is not known", "take other seeds or another corpus"
        )
    return left


def _is_bank(path: Path) -> bool:
    try:
        with open_regular(path) as file:
            return file.read(len(_SQLITE)) == _SQLITE
    except OSError as error:
        raise InputError(
            str(path), f"cannot be read ({error.strerror})", "name a bank, a corpus or a scenario"
        ) from None
