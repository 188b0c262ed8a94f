"""The backends of stage I."""

from dataclasses import dataclass
from pathlib import Path

from roadmend.language.models import open_model
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


def open_extractor(backend: str, options: BackendOptions) -> Extractor:
    """The backend of a name.

    Args:
        backend: as ``language.models`` finds it.
        options: what it may need.

    Raises:
        InputError: there is none of that name, or something that it needs is missing or unusable.
    """
    model = open_model(backend, options.settings, options.recording)
    return EmbeddedExtractor() if model is None else LanguageExtractor(model, options.stage_one)
