"""The analysis of many bags: incidents bag by bag, patterns over all of them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.recording.layout import METADATA_FILE
from roadmend.sera.analyser import Analyser
from roadmend.sera.incident import Incident
from roadmend.sera.incidents import find_incidents
from roadmend.sera.pattern import FailurePattern


@dataclass(frozen=True, slots=True)
class BagAnalysis:
    """What one bag came to."""

    bag: str
    incidents: tuple[Incident, ...] = ()
    problem: str = ""  # why it cannot be read


@dataclass(frozen=True, slots=True)
class UnreadableBag:
    """A bag that was left out."""

    bag: str
    problem: str


@dataclass(frozen=True, slots=True)
class Analysis:
    """All incidents of some bags, and the patterns in them."""

    analyser: str
    bags: tuple[str, ...]  # that were read
    unreadable: tuple[UnreadableBag, ...]
    patterns: tuple[FailurePattern, ...]
    incidents: tuple[Incident, ...]


def find_bags(paths: Iterable[Path]) -> list[Path]:
    """The bags that paths name, each a bag's folder, an MCAP file or a folder with bags in it; each once.

    Raises:
        InputError: a path is not there, or holds no bag.
    """
    found: dict[Path, Path] = {}
    for path in paths:
        if not path.exists():
            raise InputError(str(path), "there is no such bag or folder", "name bags, or folders with bags in them")
        bags = [path] if _is_bag(path) else sorted(each for each in path.rglob("*") if _is_bag(each, path))
        if not bags:
            raise InputError(str(path), "holds no bag", "name bags, or folders with bags in them")
        for bag in bags:
            found.setdefault(bag.resolve(), bag)
    return list(found.values())


def read_incidents(bag: Path) -> BagAnalysis:
    """The incidents of a bag; a bag that cannot be read is a result here."""
    try:
        return BagAnalysis(str(bag), find_incidents(bag))
    except InputError as error:
        return BagAnalysis(str(bag), problem=str(error))


def analyse(readings: Sequence[BagAnalysis], analyser: Analyser) -> Analysis:
    """The patterns in what the bags came to."""
    incidents = tuple(incident for reading in readings for incident in reading.incidents)
    return Analysis(
        analyser.name,
        tuple(reading.bag for reading in readings if not reading.problem),
        tuple(UnreadableBag(reading.bag, reading.problem) for reading in readings if reading.problem),
        analyser.analyse(incidents),
        incidents,
    )


def _is_bag(path: Path, folder: Path | None = None) -> bool:
    """Whether it is a bag, whole or cut short; in a folder only bags' folders count, and none that is hidden."""
    if path.is_dir():
        hidden = folder is not None and any(part.startswith(".") for part in path.relative_to(folder).parts)
        return not hidden and ((path / METADATA_FILE).exists() or next(path.glob("*.mcap"), None) is not None)
    return folder is None and path.suffix == ".mcap"
