"""What the commands of ``roadmend sera`` share: options, and asking a language model."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import click

from roadmend.cli.language_options import LanguageChoice
from roadmend.cli.options import FILE, ModelType, options_of, settings_file
from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.language.exchange import ENDING
from roadmend.sera.backends import Backend
from roadmend.sera.evaluation_set import chosen_set
from roadmend.sera.filters import Filters
from roadmend.training.few_shot_settings import FewShotSettings, read_few_shot_settings
from roadmend.world.corpus import SPLITS
from roadmend.world.scenario import Scenario

BANK = click.option("--bank", "bank_file", required=True, type=FILE, help="Bank to read.")
NEURAL_POLICY = click.option(
    "--policy",
    default="neural",
    show_default=True,
    type=ModelType(),
    help="A neural policy that ships, or its model file.",
)
PATTERN = click.option(
    "--pattern",
    "patterns",
    required=True,
    multiple=True,
    help="What is looked for: a JSON or YAML file of failure patterns, or words. May be repeated.",
)
EMBEDDER = click.option(
    "--embedder",
    help="That the bank must have been made with; needed where it is code of yours, which is not run otherwise.",
)


def filter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """One option for each group of the filters, to be repeated; the command gets as ``terms`` what ``filters_of`` takes."""
    groups = [field.name for field in fields(Filters)]

    @wraps(command)
    def with_terms(**given: Any) -> Any:
        return command(terms={group: given.pop(group) for group in groups}, **given)

    for group in reversed(groups):
        text = f"Only scenarios with this {group}; may be repeated."
        with_terms = click.option(f"--{group}", multiple=True, help=text)(with_terms)
    return with_terms


def filters_of(given: dict[str, tuple[str, ...]]) -> Filters:
    """The filters that the options stand for.

    Raises:
        InputError: a group has no such value.
    """
    return Filters(**given)


@dataclass(frozen=True)
class SetChoice:
    """An evaluation set: random scenarios, or a corpus."""

    scenarios: Annotated[
        int | None,
        click.option(
            "--scenarios", type=click.IntRange(1, 100_000), help="Random scenarios of each family.  [default: 20]"
        ),
    ]
    first_seed: Annotated[
        int | None,
        click.option("--first-seed", type=click.IntRange(0, 2**30), help="Of the random scenarios.  [default: 0]"),
    ]
    corpus: Annotated[Path | None, click.option("--corpus", type=FILE, help="Its cases instead of random scenarios.")]
    split: Annotated[
        str | None, click.option("--split", type=click.Choice(SPLITS), help="Of the corpus.  [default: all]")
    ]

    def read(self) -> list[Scenario]:
        """The scenarios of the set.

        Raises:
            InputError: the options contradict each other, or the file is no corpus.
        """
        return chosen_set(self.scenarios, self.first_seed, self.corpus, self.split)


set_options = options_of(SetChoice, "chosen")


@dataclass(frozen=True)
class FewShotChoice:
    """How a policy is tuned."""

    file: Annotated[
        Path | None,
        settings_file("YAML file with the settings of the tuning; config/training/few-shot.yaml if not given."),
    ]
    epochs: Annotated[
        int | None, click.option("--epochs", type=click.IntRange(1, 100), help="Instead of the settings'.")
    ]

    def read(self) -> FewShotSettings:
        """The settings that the options make.

        Raises:
            InputError: the file cannot be read, or a name or value of it is unknown or out of range.
        """
        settings = read_few_shot_settings(self.file or config_folder() / "training" / "few-shot.yaml")
        return settings if self.epochs is None else settings.model_copy(update={"epochs": self.epochs})


few_shot_options = options_of(FewShotChoice, "few_shot")


def open_backend(choice: LanguageChoice, out: Path | None) -> Backend:
    """The backend that the options stand for.

    Raises:
        InputError: it lacks something, or there is no place for what a language model is asked.
    """
    backend = Backend.open(choice.backend, choice.settings, choice.recording, choice.attempts)
    if backend.model is not None and out is None:
        raise InputError(f"backend {choice.backend}", "has no place for what is said", "name a file with --out")
    return backend


@contextmanager
def keeping_exchanges(backend: Backend, out: Path | None) -> Iterator[None]:
    """Writes beside the output what was said to a language model; when nothing comes of it, after what is there.

    Raises:
        InputError: the place cannot be written.
    """
    is_done = False
    try:
        yield
        is_done = True
    finally:
        if out is not None:
            backend.keep(out.with_suffix(ENDING), adding=not is_done)
