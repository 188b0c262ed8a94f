"""What the benchmark of SERA is made of: its plan, its bank, and its evaluation set in two halves."""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from roadmend.core.errors import InputError
from roadmend.core.settings import check_settings
from roadmend.core.yaml_file import read_fields
from roadmend.sera.describe import entry_of, entry_of_case
from roadmend.sera.descriptor import BankEntry
from roadmend.sera.evaluation_set import Known
from roadmend.world.corpus import Corpus, load_corpus
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario

_QUICK = "quick"


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SetPlan(_Part):
    """A set of scenarios: cases of corpora, and random ones; counts are for each family."""

    corpora: list[str]
    split: str
    violations: int = Field(ge=0)
    successes: int = Field(ge=0)
    ordinary: int = Field(ge=0)
    first_seed: int = Field(ge=0)


class SweepPlan(_Part):
    """Settings that are tried one by one."""

    epochs: list[int]
    learning_rates: list[float]


class SeraPlan(_Part):
    """tests/benchmarks/sera.yaml."""

    policies: list[str]
    in_depth: list[str]  # those of them that half the bank and the sweep are tried on, too
    seeds: int = Field(ge=1)
    scenarios: int = Field(ge=1)
    validation: int = Field(ge=0)
    few_shot: dict[str, Any] = {}  # settings in the place of those of config/training/few-shot.yaml
    bank: SetPlan
    evaluation: SetPlan
    sweep: SweepPlan


@dataclass(frozen=True, slots=True)
class Evaluated:
    """A scenario of the evaluation set."""

    scenario: Scenario
    is_hard: bool  # a violation of the corpus; else it is ordinary, or went well there


def read_sera_plan(path: Path, *, quick: bool = False) -> SeraPlan:
    """The plan; ``quick`` puts what the file says under that name above the rest.

    Raises:
        InputError: the file is missing or holds no plan.
    """
    content = read_fields(path, "mend the file")
    changes = content.pop(_QUICK, {})
    if not isinstance(changes, dict):
        raise InputError(str(path), f"field {_QUICK} holds no fields", "mend the file")
    return check_settings(content | changes if quick else content, SeraPlan, str(path), "mend the file")


def load_corpora(plan: SetPlan, config: Path) -> list[Corpus]:
    """The corpora that a set takes cases from.

    Raises:
        InputError: one is missing or damaged.
    """
    return [load_corpus(config / name) for name in plan.corpora]


def evaluation_set(plan: SetPlan, corpora: Sequence[Corpus]) -> list[Evaluated]:
    """The scenarios of the evaluation set: cases of the corpora, and random ones."""
    found = [
        Evaluated(case.scenario(), case.is_violation)
        for corpus in corpora
        for family in FAMILIES
        for is_hard, count in ((True, plan.violations), (False, plan.successes))
        for case in corpus.select(family, plan.split, violation=is_hard)[:count]
    ]
    return [*found, *(Evaluated(scenario, is_hard=False) for scenario in _ordinary(plan))]


def bank_entries(plan: SetPlan, config: Path, known: Known) -> Iterator[BankEntry]:
    """The scenarios of the bank, those that are known left out.

    Raises:
        InputError: a corpus is missing or damaged.
    """
    for corpus in load_corpora(plan, config):
        for family in FAMILIES:
            for is_hard, count in ((True, plan.violations), (False, plan.successes)):
                for case in corpus.select(family, plan.split, violation=is_hard)[:count]:
                    if not known.holds(case.scenario()):
                        yield entry_of_case(case, corpus)
    for scenario in _ordinary(plan):
        if not known.holds(scenario):
            yield entry_of(scenario, f"family {scenario.family}")


def known_scenarios(evaluated: Sequence[Evaluated]) -> Known:
    """Digests of the evaluation set, for what must be disjoint from it."""
    return Known.of([each.scenario for each in evaluated])


def halves(evaluated: Sequence[Evaluated], seed: int) -> tuple[list[Evaluated], list[Evaluated]]:
    """The half whose failures are analysed, and the half that is measured; alike in families and in hard ones."""
    groups: dict[tuple[str | None, bool], list[Evaluated]] = {}
    for each in evaluated:
        groups.setdefault((each.scenario.family, each.is_hard), []).append(each)
    analysed, measured = list[Evaluated](), list[Evaluated]()
    generator = random.Random(f"roadmend/sera/halves/{seed}")
    for group in groups.values():
        generator.shuffle(group)
        # Of an odd group the larger part goes to the smaller half.
        middle = len(group) // 2 + (len(group) % 2 and len(analysed) < len(measured))
        analysed += group[:middle]
        measured += group[middle:]
    return analysed, measured


def _ordinary(plan: SetPlan) -> list[Scenario]:
    return [sample_scenario(family, plan.first_seed + number) for number in range(plan.ordinary) for family in FAMILIES]
