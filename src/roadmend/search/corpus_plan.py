"""What a corpus is to hold and which searches are to find it."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import read_settings
from roadmend.measures.need import PERSISTENT
from roadmend.search.campaign import Campaign
from roadmend.search.evaluation import Subject
from roadmend.search.registry import read_technique_parameters
from roadmend.world.corpus import METHOD

FRESH_SEED, FRESH_STRIDE = 10_000_000, 1000  # searches of fresh test sets: FRESH_SEED + FRESH_STRIDE * seed + k
LAST_FRESH = (2**31 - 1 - FRESH_SEED) // FRESH_STRIDE - 1  # the greatest seed of one
_MEND = "see config/search/corpus.yaml for names and defaults"
Technique = Literal["random", "avfuzzer", "behavexplor"]


class SplitPlan(Parameters):
    """One split of one family: campaigns k = 0, 1, 2, ... until there are violations enough."""

    violations: int = Field(ge=0, le=100_000)
    successes: int = Field(ge=0, le=100_000)
    first_seed: int = Field(ge=0, le=2**31 - 1, description="campaign k searches with seed first_seed + k")
    techniques: tuple[Technique, ...] = Field(min_length=1, description="campaign k uses the (k mod n)-th")
    parameters: dict[Technique, dict[str, Any]] = Field({}, description="of techniques, where not the defaults")
    budget: int = Field(ge=1, le=1_000_000, description="evaluations of a campaign")
    most_per_campaign: int | None = Field(None, ge=1, description="violations taken from one campaign")
    least_distance: float = Field(ge=0.0, le=1.0, description="between points taken from one campaign")
    futures: int = Field(0, ge=0, le=1000, description="by which the persistence of a violation is told; 0: it is not")
    least_persistence: float = Field(0.0, ge=0.0, le=1.0, description="of the violations taken; needs futures")

    @field_validator("parameters")
    @classmethod
    def _check_parameters(cls, given: dict[Technique, dict[str, Any]]) -> dict[Technique, dict[str, Any]]:
        for technique, values in given.items():
            try:
                read_technique_parameters(technique, values)
            except InputError as error:
                raise ValueError(f"{error.where}: {error.what}") from None
        return given

    @model_validator(mode="after")
    def _check_persistence(self) -> Self:
        if self.least_persistence and not self.futures:
            raise ValueError(f"least_persistence {self.least_persistence:g} needs futures, of which there are 0")
        return self

    def campaign(self, family: str, policy: str, number: int) -> Campaign:
        """The ``number``-th search of this split in a family.

        Raises:
            InputError: there is no such family or policy.
        """
        technique = self.techniques[number % len(self.techniques)]
        subject = Subject(family, policy, METHOD, self.first_seed + number)
        return Campaign(subject, technique, read_technique_parameters(technique, self.parameters.get(technique)))


_CYCLE: tuple[Technique, ...] = ("avfuzzer", "avfuzzer", "behavexplor", "avfuzzer", "random")


class CorpusPlan(Parameters):
    """The splits of every family, in the order in which they take their pick."""

    most_campaigns: int = Field(40, ge=1, le=1000, description="of one split of one family")
    test: SplitPlan = SplitPlan(
        violations=40,
        successes=40,
        first_seed=4_000_000,
        techniques=_CYCLE,
        budget=300,
        most_per_campaign=12,
        least_distance=0.03,
        futures=20,
        least_persistence=PERSISTENT,
    )
    validation: SplitPlan = SplitPlan(
        violations=20,
        successes=20,
        first_seed=2_000_000,
        techniques=_CYCLE,
        budget=300,
        most_per_campaign=12,
        least_distance=0.03,
        futures=20,
    )
    training: SplitPlan = SplitPlan(
        violations=200,
        successes=200,
        first_seed=3_000_000,
        techniques=("avfuzzer",),
        parameters={"avfuzzer": {"patience": 4}},
        budget=400,
        most_per_campaign=40,
        least_distance=0.01,
        futures=5,
    )

    @field_validator("test", "validation", "training", mode="before")
    @classmethod
    def _complete(cls, given: object, info: ValidationInfo) -> object:
        """What a file leaves out of a split is as by that split's default, not by one for all three."""
        if not isinstance(given, Mapping) or info.field_name is None:
            return given
        return {**cls.model_fields[info.field_name].default.model_dump(), **given}

    def splits(self) -> Iterator[tuple[str, SplitPlan]]:
        """Names and plans; the first to take a case keeps it."""
        yield from (("test", self.test), ("validation", self.validation), ("training", self.training))

    @property
    def wanted(self) -> int:
        """Cases of one family."""
        return sum(split.violations + split.successes for _, split in self.splits())


def read_corpus_plan(path: Path | None) -> CorpusPlan:
    """A plan from a YAML file; what it leaves out, of a split too, is as by default. Without a file, the default.

    Raises:
        InputError: the file cannot be read, or a value is unknown or out of range.
    """
    return CorpusPlan() if path is None else read_settings(path, CorpusPlan, _MEND)


def fresh_plan(seed: int, cases: int) -> CorpusPlan:
    """A test set alone, from seeds that no other plan uses.

    Args:
        seed: which of them.
        cases: violations, and as many successes, of each family.

    Raises:
        InputError: the seed or the number of cases is out of range.
    """
    if not 0 <= seed <= LAST_FRESH:
        raise InputError("fresh seed", f"{seed} is out of range", f"choose one from 0 to {LAST_FRESH}")
    if not 1 <= cases <= 1000:
        raise InputError("cases", f"{cases} is out of range", "choose a number from 1 to 1000")
    default = CorpusPlan()
    nothing = {"violations": 0, "successes": 0}
    own = {"violations": cases, "successes": cases, "first_seed": FRESH_SEED + FRESH_STRIDE * seed}
    return CorpusPlan(
        test=default.test.model_copy(update=own),
        validation=default.validation.model_copy(update=nothing),
        training=default.training.model_copy(update=nothing),
    )
