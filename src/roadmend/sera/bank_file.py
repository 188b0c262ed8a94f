"""A bank on disk: one SQLite file with the entries, the embedder and the index; written beside its place, then moved."""

import hashlib
import os
import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from roadmend.core.bounded_file import unpack_zlib
from roadmend.core.bounds import ARRAYS, SETTINGS
from roadmend.core.errors import InputError
from roadmend.core.whole_file import written_beside
from roadmend.sera.descriptor import BankEntry, Descriptor
from roadmend.world.scenario import Scenario

FORMAT = "roadmend-bank/1"
_APPLICATION = 0x726D6261  # marks the file as ours, in SQLite's header
_PART = 64 * 2**20  # [bytes] of an array are read and written at a time
_SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE entries (
    number INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, name TEXT NOT NULL, origin TEXT NOT NULL,
    facets INTEGER NOT NULL, descriptor BLOB NOT NULL, scenario BLOB, skeleton TEXT
);
CREATE INDEX skeletons ON entries (skeleton) WHERE skeleton IS NOT NULL;
CREATE TABLE parts (name TEXT, place INTEGER, content BLOB NOT NULL, PRIMARY KEY (name, place));
"""
REMEDY = "build it again, or import an export of it"
DAMAGE = (  # what a damaged file raises; pydantic's errors are ValueErrors, too
    sqlite3.DatabaseError,
    LookupError,
    ValueError,
    TypeError,
    OverflowError,
    MemoryError,  # of SQLite, for a page that names more bytes than there can be; nothing was taken
)
_COLUMNS = "digest, name, origin, descriptor, scenario"
DESCRIPTOR: TypeAdapter[Descriptor] = TypeAdapter(Descriptor)


@contextmanager
def new_file(path: Path) -> Iterator[sqlite3.Connection]:
    """A fresh file that takes its place only when the block ends well; a place already taken keeps its file till then.

    Raises:
        InputError: the place cannot be written.
    """
    try:
        with written_beside(path) as beside:
            with closing(sqlite3.connect(beside)) as connection:
                # Nobody sees the file before it is whole, so there is nothing for a journal to roll back.
                connection.executescript(f"PRAGMA journal_mode=OFF; PRAGMA application_id={_APPLICATION}; {_SCHEMA}")
                yield connection
                connection.commit()
            with beside.open("rb") as file:
                os.fsync(file.fileno())
    except sqlite3.OperationalError as error:
        raise InputError(str(path), f"cannot be written ({error})", "choose a writable place with room") from None


def open_file(path: Path) -> tuple[sqlite3.Connection, dict[str, str]]:
    """A bank to read, and what it says about itself.

    Raises:
        InputError: the file is missing, is no bank, is damaged, or is of another version.
    """
    if not path.is_file():
        raise InputError(str(path), "no such file", "give a bank; 'roadmend sera bank build' makes one")
    connection = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 2 * _PART)  # a longer value is none of ours
        meta = _read_meta(path, connection)
    except DAMAGE as error:
        connection.close()
        raise InputError(str(path), f"is no bank or is damaged ({words_of(error)})", REMEDY) from None
    except InputError:
        connection.close()
        raise
    return connection, meta


def words_of(error: BaseException) -> str:
    """What an error says, in one line; its kind where it says nothing."""
    return next(iter(str(error).splitlines()), type(error).__name__)


def _read_meta(path: Path, connection: sqlite3.Connection) -> dict[str, str]:
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    if application != _APPLICATION:
        raise InputError(str(path), "is no bank", "give a file that 'roadmend sera bank build' made")
    # A view may never end. Only tables are ours.
    if connection.execute("SELECT count(*) FROM sqlite_schema WHERE type NOT IN ('table', 'index')").fetchone()[0]:
        raise InputError(str(path), "holds more than tables", REMEDY)
    meta = dict(connection.execute("SELECT key, value FROM meta"))
    if meta.get("format") != FORMAT:
        raise InputError(
            str(path),
            f"has the format {meta.get('format')!r}, not {FORMAT!r}",
            "export it with the roadmend that wrote it, and import that here",
        )
    return meta


def pack(entry: BankEntry, facets: int, shape: str | None) -> tuple[Any, ...]:
    """The entry as a row, without its number."""
    content = DESCRIPTOR.dump_json(entry.descriptor, exclude_defaults=True)
    scenario = None if entry.scenario is None else zlib.compress(entry.scenario.model_dump_json().encode())
    return entry.digest, entry.name, entry.origin, facets, content, scenario, shape


def read_entries(
    connection: sqlite3.Connection, where: str = "", values: Sequence[Any] = ()
) -> Iterator[tuple[int, BankEntry]]:
    """Numbers and entries, by number.

    Raises:
        InputError: a row is damaged.
    """
    try:
        rows = connection.execute(f"SELECT number, {_COLUMNS} FROM entries {where} ORDER BY number", values)  # noqa: S608
        for number, digest, name, origin, content, packed in rows:
            scenario = None if packed is None else Scenario.model_validate_json(unpack_zlib(packed, SETTINGS))
            yield number, BankEntry(digest, name, origin, DESCRIPTOR.validate_json(content), scenario)
    except DAMAGE as error:
        raise InputError("bank", f"is damaged ({words_of(error)})", REMEDY) from None


def read_descriptors(connection: sqlite3.Connection, step: int = 1) -> Iterator[Descriptor]:
    """Descriptors alone, by number; every ``step``-th."""
    rows = connection.execute("SELECT descriptor FROM entries WHERE number % ? = 0 ORDER BY number", (step,))
    return (DESCRIPTOR.validate_json(content) for (content,) in rows)


def write_array(connection: sqlite3.Connection, name: str, array: NDArray[Any]) -> None:
    """Store an array in parts, with a digest of it; a memory map is read part by part."""
    step = max(1, _PART // max(1, array.itemsize * int(np.prod(array.shape[1:]))))
    digest = hashlib.sha256()
    for start in range(0, len(array), step):
        content = np.ascontiguousarray(array[start : start + step]).tobytes()
        digest.update(content)
        connection.execute("INSERT INTO parts VALUES (?, ?, ?)", (name, start, content))
    connection.execute("INSERT INTO meta VALUES (?, ?)", (f"sha256 {name}", digest.hexdigest()))


def read_array(connection: sqlite3.Connection, meta: dict[str, str], name: str, dtype: Any) -> NDArray[Any]:
    """An array that was stored, flat; in memory once.

    Raises:
        ValueError: it is not what was stored.
        sqlite3.DatabaseError: the file is damaged.
    """
    (size,) = connection.execute("SELECT total(length(content)) FROM parts WHERE name = ?", (name,)).fetchone()
    if size > ARRAYS.unpacked:
        raise ValueError(f"its {name} take {size / 1e6:.0f} MB")
    result = np.empty(int(size), dtype=np.uint8)
    digest, start = hashlib.sha256(), 0
    for (content,) in connection.execute("SELECT content FROM parts WHERE name = ? ORDER BY place", (name,)):
        digest.update(content)
        result[start : start + len(content)] = np.frombuffer(content, dtype=np.uint8)
        start += len(content)
    if digest.hexdigest() != meta.get(f"sha256 {name}"):
        raise ValueError(f"its {name} are not what was written")
    return result.view(dtype)
