"""Language models: ours by name, and those of others."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.foreign import ForeignClass
from roadmend.core.registry import Registry
from roadmend.language.chat import ChatModel
from roadmend.language.exchange import ReplayModel
from roadmend.language.foreign import ForeignModel

EMBEDDED = "embedded"  # the backend that asks no model: rules that come with roadmend
Open = Callable[[Path | None, Path | None], ChatModel]


def _openai(settings: Path | None, _: Path | None) -> ChatModel:
    # Its client takes a second to import, and most runs do without.
    from roadmend.language.openai_chat import OpenAIModel, read_openai_settings  # noqa: PLC0415

    return OpenAIModel(read_openai_settings(settings))


def _replay(_: Path | None, recording: Path | None) -> ChatModel:
    if recording is None:
        raise InputError("backend replay", "has no recording", "name one with --recording")
    return ReplayModel(recording)


MODELS: Mapping[str, Open] = {"openai": _openai, "replay": _replay}
"""Each is opened with a file of settings, for openai, and recorded exchanges, for replay; it takes what is its own."""


def _of_class(given: str, thing: Any) -> Open | None:
    found = ForeignClass.check(f"backend {given}", thing, ChatModel, ["settings", "recording"])
    return lambda settings, recording: ForeignModel(given, found.make(settings=settings, recording=recording))


BACKENDS: Mapping[str, Open | None] = {EMBEDDED: None, **MODELS}
BACKEND_REGISTRY = Registry("backend", "roadmend.backends", BACKENDS, _of_class)


def open_model(name: str, settings: Path | None = None, recording: Path | None = None) -> ChatModel | None:
    """The language model of a backend; None for the one that asks none.

    Args:
        name: of ours or of an installed package's, or ``package.module:Class``.
        settings: file with the settings of openai; None for its environment alone.
        recording: recorded exchanges, for replay.

    Raises:
        InputError: there is no such backend, or something that it needs is missing or unusable.
    """
    make = BACKEND_REGISTRY.find(name).entry
    return None if make is None else make(settings, recording)
