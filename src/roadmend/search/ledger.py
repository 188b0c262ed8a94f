"""A search on disk: the ledger of every evaluated point, and a scenario for every violation."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from pydantic import TypeAdapter

from roadmend.core.errors import InputError
from roadmend.core.journal import Journal, Key
from roadmend.search.evaluation import Evaluation

FORMAT = "roadmend-search/4"
LEDGER = "ledger.jsonl"
FOUND = "found"


@dataclass(frozen=True, slots=True)
class RerunCommand:
    """How to see a violation again."""

    scenario: str  # file, seen from the search's folder
    command: str  # to be given in the search's folder
    policy: str  # a model file as it is seen from the search's folder
    method: str


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """One line of the ledger. Holds no time and no place: a search gives the same lines wherever it runs."""

    index: int  # of the evaluation, from 0
    key: Key  # digest of the point, and of all that decides what it comes to
    evaluation: Evaluation
    reproduction: RerunCommand | None = None  # of a violation


_PLAIN = TypeAdapter(LedgerEntry)


class Ledger:
    """The folder of one search, open in one process at a time. ``entries`` are those on disk, in order."""

    def __init__(self, folder: Path, settings: Mapping[str, Any]) -> None:
        """Open a folder, or make it.

        Args:
            folder: where to keep the search.
            settings: plain values that decide what the search does, its code and models among them; a folder keeps to
                one set of them.

        Raises:
            InUseError: another process is at work there.
            InputError: the folder holds another search or something else, or cannot be written.
        """
        self.folder = folder
        self._journal = Journal(folder / LEDGER, FORMAT, settings, owns_folder=True)
        try:
            self.entries = self._read()
        except BaseException:
            self._journal.__exit__()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._journal.__exit__()

    def add(self, entry: LedgerEntry) -> None:
        """Write one line.

        Raises:
            InputError: the disk is full or gone.
        """
        self._journal.add(entry.key, _PLAIN.dump_python(entry, mode="json", exclude={"key"}))
        self.entries.append(entry)

    def _read(self) -> list[LedgerEntry]:
        entries: list[LedgerEntry] = []
        for number, (key, content) in enumerate(self._journal, 2):
            try:
                entry = _PLAIN.validate_python({"key": key, **content})
            except ValueError:
                raise self._journal.damaged(number) from None
            if entry.index != len(entries):
                what = "is out of order"
                raise InputError(f"{self._journal.path} line {number}", what, "choose another folder")
            entries.append(entry)
        return entries
