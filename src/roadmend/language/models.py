"""Language models by name."""

from collections.abc import Callable, Mapping
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.language.chat import ChatModel
from roadmend.language.exchange import ReplayModel


def _openai(settings: Path | None, _: Path | None) -> ChatModel:
    # Its client takes a second to import, and most runs do without.
    from roadmend.language.openai_chat import OpenAIModel, read_openai_settings  # noqa: PLC0415

    return OpenAIModel(read_openai_settings(settings))


def _replay(_: Path | None, recording: Path | None) -> ChatModel:
    if recording is None:
        raise InputError("backend replay", "has no recording", "name one with --recording")
    return ReplayModel(recording)


MODELS: Mapping[str, Callable[[Path | None, Path | None], ChatModel]] = {"openai": _openai, "replay": _replay}
"""Each is opened with a file of settings, for openai, and recorded exchanges, for replay; it takes what is its own."""
