"""A search on disk: the ledger of every evaluated point, and a scenario for every violation."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from roadmend.core.errors import InputError
from roadmend.core.journal import Journal, Key
from roadmend.core.outcome import Blame
from roadmend.search.evaluation import Evaluation

FORMAT = "roadmend-search/3"
LEDGER = "ledger.jsonl"
FOUND = "found"


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
    key: Key  # digest of the point, and of all that decides what it comes to
    evaluation: Evaluation
    reproduction: Reproduction | None = None  # of a violation

    def dump(self) -> dict[str, Any]:
        """As plain values, without the key."""
        content: dict[str, Any] = {"index": self.index, **asdict(self.evaluation)}
        if self.reproduction is not None:
            content["reproduction"] = asdict(self.reproduction)
        return content

    @classmethod
    def parse(cls, key: Key, values: Mapping[str, Any]) -> Self:
        """From plain values.

        Raises:
            ValueError: they are no entry.
        """
        try:
            content = dict(values)
            index, given = content.pop("index"), content.pop("reproduction", None)
            content["blame"] = Blame(content["blame"])
            content["features"] = tuple(content["features"])
            return cls(index, key, Evaluation(**content), Reproduction(**given) if given else None)
        except (AttributeError, KeyError, TypeError) as error:
            raise ValueError(str(error)) from None


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

    def add(self, entry: Entry) -> None:
        """Write one line.

        Raises:
            InputError: the disk is full or gone.
        """
        self._journal.add(entry.key, entry.dump())
        self.entries.append(entry)

    def _read(self) -> list[Entry]:
        entries: list[Entry] = []
        for number, (key, content) in enumerate(self._journal, 2):
            try:
                entry = Entry.parse(key, content)
            except ValueError:
                raise self._journal.damaged(number) from None
            if entry.index != len(entries):
                what = "is out of order"
                raise InputError(f"{self._journal.path} line {number}", what, "choose another folder")
            entries.append(entry)
        return entries
