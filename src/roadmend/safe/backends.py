"""The backends of stage I by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from roadmend.language.models import MODELS
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction import Extractor
from roadmend.safe.stage_one import LanguageExtractor, StageOneOptions


@dataclass(frozen=True, slots=True)
class BackendOptions:
    """What a backend may need; each takes what is its own.

    Attributes:
        stage_one: see ``StageOneOptions``.
        settings: file with the settings of openai; None for its environment alone.
        recording: recorded exchanges, for replay.
    """

    stage_one: StageOneOptions
    settings: Path | None = None
    recording: Path | None = None


def _embedded(_: BackendOptions) -> Extractor:
    return EmbeddedExtractor()


def _language(name: str, options: BackendOptions) -> Extractor:
    return LanguageExtractor(MODELS[name](options.settings, options.recording), options.stage_one)


BACKENDS: Mapping[str, Callable[[BackendOptions], Extractor]] = {
    "embedded": _embedded,
    **{name: partial(_language, name) for name in MODELS},
}
