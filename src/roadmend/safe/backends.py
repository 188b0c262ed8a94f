"""The backends of stage I by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.language.replay import ReplayModel
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


def _openai(options: BackendOptions) -> Extractor:
    # Its client takes a second to import, and most runs do without.
    from roadmend.language.openai_chat import OpenAIModel, read_openai_settings  # noqa: PLC0415

    return LanguageExtractor(OpenAIModel(read_openai_settings(options.settings)), options.stage_one)


def _replay(options: BackendOptions) -> Extractor:
    if options.recording is None:
        raise InputError("backend replay", "has no recording", "name one with --recording")
    return LanguageExtractor(ReplayModel(options.recording), options.stage_one)


BACKENDS: Mapping[str, Callable[[BackendOptions], Extractor]] = {
    "embedded": _embedded,
    "openai": _openai,
    "replay": _replay,
}
