"""Who analyses and who reflects, by name: the same names for both, and for stage I of SAFE."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

from roadmend.core.whole_file import written_beside
from roadmend.language.exchange import RecordingModel, Usage, dump_exchanges, usage_of
from roadmend.language.models import open_model
from roadmend.language.question import ATTEMPTS
from roadmend.sera.analyser import Analyser, EmbeddedAnalyser
from roadmend.sera.language_analyser import LanguageAnalyser
from roadmend.sera.language_reflection import LanguageReflector
from roadmend.sera.reflection import EmbeddedReflector, Reflector


@dataclass(frozen=True)
class Backend:
    """An analyser and a reflector, and what a language model was asked on their behalf; no model if embedded."""

    analyser: Analyser
    reflector: Reflector
    model: RecordingModel | None = None

    @classmethod
    def open(
        cls, name: str, settings: Path | None = None, recording: Path | None = None, attempts: int = ATTEMPTS
    ) -> Self:
        """The backend of a name.

        Args:
            name: as ``language.models`` finds it.
            settings: file with the settings of openai; None for its environment alone.
            recording: recorded exchanges, for replay.
            attempts: answers that a question may take.

        Raises:
            InputError: there is none of that name, or something that it needs is missing or unusable.
        """
        opened = open_model(name, settings, recording)
        if opened is None:
            return cls(EmbeddedAnalyser(), EmbeddedReflector())
        model = RecordingModel(opened)
        return cls(LanguageAnalyser(model, attempts), LanguageReflector(model, attempts), model)

    def exchanges(self) -> str:
        """What was said to the model and what it answered, one JSON object a line; a replay reads it."""
        return dump_exchanges(self.model.exchanges) if self.model is not None else ""

    def keep(self, path: Path, *, adding: bool) -> None:
        """Keep in a file what was said so far; a recording that is being replayed stays as it is.

        Args:
            path: of the file.
            adding: to what is there, which is replaced otherwise.

        Raises:
            InputError: the place cannot be written.
        """
        said = self.exchanges()
        replayed = () if self.model is None else getattr(self.model.model, "files", ())
        if not said or (path.exists() and any(path.samefile(each) for each in replayed)):
            return
        with written_beside(path) as beside:
            earlier = path.read_bytes() if adding and path.exists() else b""
            beside.write_bytes(earlier + said.encode("utf-8"))

    def usage(self) -> dict[str, Usage]:
        """What was used up so far, by model."""
        return usage_of(self.model.exchanges) if self.model is not None else {}
