"""A search on disk: ``settings.json``, the ledger of every evaluated point, and a scenario for every violation."""

import fcntl
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from roadmend.core.errors import InputError
from roadmend.core.outcome import Blame
from roadmend.core.whole_file import write_text
from roadmend.search.evaluation import Evaluation

FORMAT = "roadmend-search/2"
SETTINGS = "settings.json"
LEDGER = "ledger.jsonl"
FOUND = "found"


class InUseError(InputError):
    """Another process is at work in the folder."""


@dataclass(frozen=True, slots=True)
class Reproduction:
    """How to see a violation again."""

    scenario: str  # file, seen from the search's folder
    command: str  # to be given in the search's folder
    policy: str
    method: str


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of the ledger. Holds no time and no place: a search gives the same lines wherever it runs."""

    index: int  # of the evaluation, from 0
    parameters: str  # digest of the point
    evaluation: Evaluation
    reproduction: Reproduction | None = None  # of a violation

    def dump(self) -> str:
        """As a line of JSON."""
        content: dict[str, Any] = {"index": self.index, "parameters": self.parameters, **asdict(self.evaluation)}
        if self.reproduction is not None:
            content["reproduction"] = asdict(self.reproduction)
        return json.dumps(content) + "\n"

    @classmethod
    def parse(cls, line: str) -> Self:
        """From a line of JSON.

        Raises:
            ValueError: the line is no entry.
        """
        try:
            content = json.loads(line)
            index, parameters = content.pop("index"), content.pop("parameters")
            given = content.pop("reproduction", None)
            content["blame"] = Blame(content["blame"])
            content["features"] = tuple(content["features"])
            return cls(index, parameters, Evaluation(**content), Reproduction(**given) if given else None)
        except (AttributeError, KeyError, TypeError) as error:
            raise ValueError(str(error)) from None


class Ledger:
    """The folder of one search, open in one process at a time.

    Lines are only ever added, each with one write; a line that an interruption cut short is dropped at the next
    opening. ``entries`` are those on disk, in order.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any]) -> None:
        """Open a folder, or make it.

        Args:
            folder: where to keep the search.
            settings: plain values that decide what the search does; a folder keeps to one set of them.

        Raises:
            InputError: the folder holds another search or something else, is in use, or cannot be written.
        """
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._check_settings({"format": FORMAT, **settings})
            self._file = (folder / LEDGER).open("a+b", buffering=0)
        except OSError as error:
            raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose a writable folder") from None
        try:
            self.entries = self._lock_and_read()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, entry: Entry) -> None:
        """Write one line.

        Raises:
            InputError: the disk is full or gone.
        """
        try:
            self._file.write(entry.dump().encode())
        except OSError as error:
            raise InputError(str(self.folder / LEDGER), f"cannot be written ({error.strerror})", "make room") from None
        self.entries.append(entry)

    def _check_settings(self, settings: Mapping[str, Any]) -> None:
        path = self.folder / SETTINGS
        if not path.exists():
            if any(self.folder.glob("[!.]*")):
                raise InputError(str(self.folder), "holds no search and is not empty", "choose another folder")
            write_text(path, json.dumps(settings, indent=2) + "\n")
            return
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
            names = [name for name in {**kept, **settings} if kept.get(name) != settings.get(name)]
        except (ValueError, TypeError, AttributeError):
            raise InputError(str(path), "is damaged", "choose another folder") from None
        if names:
            name = names[0]
            what = f"holds a search with {name} {kept.get(name)!r}, not {settings.get(name)!r}"
            raise InputError(str(self.folder), what, "choose another folder or the same settings")

    def _lock_and_read(self) -> list[Entry]:
        path = self.folder / LEDGER
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InUseError(str(self.folder), "another search is at work here", "wait for it to end") from None
        self._file.seek(0)
        content = self._file.readall() or b""
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            self._file.truncate(len(whole))
        entries: list[Entry] = []
        for number, line in enumerate(whole.splitlines()):
            try:
                entry = Entry.parse(line.decode())
            except ValueError:
                raise InputError(f"{path} line {number + 1}", "is damaged", "choose another folder") from None
            if entry.index != number:
                raise InputError(f"{path} line {number + 1}", "is out of order", "choose another folder")
            entries.append(entry)
        return entries
