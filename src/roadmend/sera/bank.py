"""The scenario bank: built once, never changed in place, searched by failure pattern."""

import hashlib
import json
import sqlite3
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.sera.bank_file import (
    DAMAGE,
    DESCRIPTOR,
    FORMAT,
    REMEDY,
    new_file,
    open_file,
    pack,
    read_array,
    read_descriptors,
    read_entries,
    words_of,
    write_array,
)
from roadmend.sera.descriptor import BankEntry, Descriptor
from roadmend.sera.embedding import DEFAULT, Embedder, Vectors, check_embedder, fit_embedder, load_embedder
from roadmend.sera.filters import Bits, Filters, facet_bits
from roadmend.sera.near_equality import content_digest, nearly_equal, skeleton
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.vector_index import Mask, VectorIndex
from roadmend.sera.words import words_of_pattern
from roadmend.world.scenario import Scenario

_TRAINED_ON = 100_000  # descriptors
_CHUNK = 2048  # descriptors at a time
Report = Callable[[str, int], None]  # a stage, and how many entries it has done


@dataclass(frozen=True, slots=True)
class Built:
    """What became of the entries that were given."""

    added: int
    merged: int  # the same scenario again, be it under another name: outcomes were added up
    near_equal: int  # left out


@dataclass(frozen=True, slots=True)
class Hit:
    """An entry that was found."""

    number: int  # of the entry in its bank
    score: float  # cosine of the angle to what was looked for


def build_bank(
    path: Path, entries: Iterable[BankEntry], embedder: str = DEFAULT, report: Report = lambda _stage, _done: None
) -> Built:
    """Write a bank, complete or not at all; the same entries in the same order give the same bank.

    Of the same scenario, under whatever names, one stays, with the outcomes of all; of nearly equal ones the first.

    Raises:
        InputError: the place cannot be written, there is no such embedder, or an entry is unusable.
        LanguageError: the endpoint of the embedder does not answer.
    """
    check_embedder(embedder)
    with new_file(path) as connection:
        built = _insert(connection, entries, report)
        model = fit_embedder(embedder, read_descriptors(connection, max(1, -(-built.added // _TRAINED_ON))))
        with tempfile.TemporaryFile(dir=path.parent) as file:
            shape = (built.added, model.dimensions)
            vectors = np.memmap(file, np.float16, "w+", shape=shape) if built.added else np.zeros(shape, np.float16)
            done = 0
            for chunk in chunks(read_descriptors(connection)):
                vectors[done : done + len(chunk)] = model.embed(chunk)
                done += len(chunk)
                report("embedded", done)
            index = VectorIndex.build(vectors)
            report("indexed", done)
            write_array(connection, "vectors", vectors)
        write_array(connection, "codes", index.dump_codes())
        write_array(connection, "embedder", np.frombuffer(model.dump(), dtype=np.uint8))
        facts = {
            "format": FORMAT,
            "roadmend": __version__,
            "embedder": model.name,
            "entries": str(built.added),
            "scenarios": _digest_of_entries(connection),
        }
        connection.executemany("INSERT INTO meta VALUES (?, ?)", facts.items())
    return built


def _digest_of_entries(connection: sqlite3.Connection) -> str:
    """SHA-256 over the digests of the scenarios in their order: what descriptors do not tell makes another bank too."""
    digest = hashlib.sha256()
    for (each,) in connection.execute("SELECT digest FROM entries ORDER BY number"):
        digest.update(f"{each}\n".encode())
    return digest.hexdigest()


def _insert(connection: sqlite3.Connection, entries: Iterable[BankEntry], report: Report) -> Built:
    added = merged = near = 0
    for done, entry in enumerate(entries, 1):
        if done % _CHUNK == 0:
            report("read", done)
        shape, like, is_same = _like(connection, entry)
        if like is None:
            values = added, *pack(entry, facet_bits(entry.descriptor), shape)
            connection.execute("INSERT INTO entries VALUES (?, ?, ?, ?, ?, ?, ?, ?)", values)
            added += 1
        elif is_same:
            _add_outcomes(connection, like, entry)
            merged += 1
        else:
            near += 1
    report("read", added + merged + near)
    return Built(added, merged, near)


def _like(connection: sqlite3.Connection, entry: BankEntry) -> tuple[str | None, int | None, bool]:
    """The skeleton of an entry's scenario; the number of a like one in the bank; whether the two are the same.

    A scenario is the same under another name, and nearly equal where its numbers hardly differ.
    """
    row = connection.execute("SELECT number FROM entries WHERE digest = ?", (entry.digest,)).fetchone()
    if row is not None or entry.scenario is None:
        return None, None if row is None else int(row[0]), True
    shape, numbers = skeleton(entry.scenario)
    content = content_digest(entry.scenario)
    near: int | None = None
    for number, other in read_entries(connection, "WHERE skeleton = ?", (shape,)):
        assert other.scenario is not None
        if content_digest(other.scenario) == content:
            return shape, number, True
        if near is None and nearly_equal(numbers, skeleton(other.scenario)[1]):
            near = number
    return shape, near, False


def _add_outcomes(connection: sqlite3.Connection, number: int, entry: BankEntry) -> None:
    (content,) = connection.execute("SELECT descriptor FROM entries WHERE number = ?", (number,)).fetchone()
    known = DESCRIPTOR.validate_json(content).with_outcomes(entry.descriptor.outcomes)
    values = DESCRIPTOR.dump_json(known, exclude_defaults=True), facet_bits(known), number
    connection.execute("UPDATE entries SET descriptor = ?, facets = ? WHERE number = ?", values)


def chunks(descriptors: Iterator[Descriptor]) -> Iterator[list[Descriptor]]:
    """As many at a time as are embedded together."""
    chunk: list[Descriptor] = []
    for descriptor in descriptors:
        chunk.append(descriptor)
        if len(chunk) == _CHUNK:
            yield chunk
            chunk = []
    if chunk:
        yield chunk


class Bank:
    """A bank open for reading. Vectors and codes are in memory, entries stay in the file."""

    def __init__(self, path: Path, embedder: str | None = None) -> None:
        """Open a bank.

        Args:
            path: of the file.
            embedder: that it must have been made with; needed where that one is the user's own code, which is not run
                because a file says so. None for whichever it was.

        Raises:
            InputError: the file is missing, is no bank, is damaged, or is of another version or embedder.
        """
        self.path = path
        self._connection, self.meta = open_file(path)
        try:
            self._load(embedder)
        except DAMAGE as error:
            self.close()
            raise InputError(str(path), f"is damaged ({words_of(error)})", REMEDY) from None
        except InputError:
            self.close()
            raise

    def _load(self, named: str | None) -> None:
        self._count = int(self.meta["entries"])
        content = read_array(self._connection, self.meta, "embedder", np.uint8)
        self.embedder: Embedder = load_embedder(self.meta["embedder"], content.tobytes(), named)
        vectors = read_array(self._connection, self.meta, "vectors", np.float16)
        codes = read_array(self._connection, self.meta, "codes", np.uint8)
        self.index = VectorIndex.load(vectors.reshape(self._count, self.embedder.dimensions), codes)
        self._facets: Bits = np.fromiter(
            (bits for (bits,) in self._connection.execute("SELECT facets FROM entries ORDER BY number")), np.uint64
        )
        if len(self._facets) != self._count:
            raise ValueError(f"it holds {len(self._facets)} of {self._count} entries")

    def __len__(self) -> int:
        return self._count

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file."""
        self._connection.close()

    @property
    def digest(self) -> str:
        """SHA-256 of what the bank says of itself, the digests of its scenarios, vectors and embedder among it."""
        return hashlib.sha256(json.dumps(self.meta, sort_keys=True).encode()).hexdigest()

    def embed(self, pattern: FailurePattern) -> Vectors:
        """The pattern as a vector, shape (dimensions,).

        Raises:
            InputError: nothing that the pattern says means anything to this bank, or its embedder cannot be used.
            LanguageError: the endpoint of the embedder does not answer.
        """
        vector: Vectors = self.embedder.embed([pattern])[0]
        if not vector.any() and len(self):
            said = words_of_pattern(pattern) or pattern.name
            raise InputError(f"pattern {said!r}", "says nothing that this bank knows", "name a road, hazard or weather")
        return vector

    def search(
        self,
        pattern: FailurePattern,
        count: int,
        filters: Filters | None = None,
        exclude: Collection[str | Scenario] = (),
    ) -> list[Hit]:
        """The entries that fit a pattern best, best first; none from an empty bank.

        Args:
            pattern: what is looked for.
            count: at most so many.
            filters: what an entry must be besides.
            exclude: what must not come, for instance of an evaluation set: scenarios, under whatever name, or digests.

        Raises:
            InputError: nothing that the pattern says means anything to this bank, or its embedder cannot be used.
            LanguageError: the endpoint of the embedder does not answer.
        """
        if not len(self):
            return []
        numbers, scores = self.index.search(self.embed(pattern), count, self.allowed(filters, exclude))
        return [Hit(int(number), float(score)) for number, score in zip(numbers, scores, strict=True)]

    def allowed(self, filters: Filters | None = None, exclude: Collection[str | Scenario] = ()) -> Mask | None:
        """Which entries may be found, shape (entries,); None for all.

        Raises:
            InputError: an entry that is like an excluded scenario is damaged.
        """
        passed = filters.matches(self._facets) if filters is not None else None
        numbers = [number for each in exclude for number in self._numbers_of(each)]
        if numbers:
            passed = np.ones(len(self), dtype=np.bool_) if passed is None else passed
            passed[numbers] = False
        return passed

    def _numbers_of(self, wanted: str | Scenario) -> list[int]:
        """Numbers of the entries of a scenario, or of one with that digest."""
        digest = wanted if isinstance(wanted, str) else wanted.digest
        found = [
            number for (number,) in self._connection.execute("SELECT number FROM entries WHERE digest = ?", (digest,))
        ]
        if not isinstance(wanted, str):
            content = content_digest(wanted)
            alike = read_entries(self._connection, "WHERE skeleton = ?", (skeleton(wanted)[0],))
            found += [number for number, each in alike if each.scenario and content_digest(each.scenario) == content]
        return found

    def entry(self, number: int) -> BankEntry:
        """One entry.

        Raises:
            InputError: it is damaged.
        """
        return next(entry for _, entry in read_entries(self._connection, "WHERE number = ?", (number,)))

    def find(self, digest: str) -> BankEntry | None:
        """The entry of the scenario with this digest, if there is one.

        Raises:
            InputError: it is damaged.
        """
        return next((entry for _, entry in read_entries(self._connection, "WHERE digest = ?", (digest,))), None)

    def entries(self) -> Iterator[BankEntry]:
        """All entries, one at a time.

        Raises:
            InputError: one is damaged.
        """
        return (entry for _, entry in read_entries(self._connection))

    def descriptors(self) -> Iterator[Descriptor]:
        """The descriptors of all entries, one at a time."""
        return read_descriptors(self._connection)

    def vectors(self, numbers: Sequence[int]) -> Vectors:
        """Vectors of entries, shape (numbers, dimensions)."""
        return np.asarray(self.index.vectors[list(numbers)], dtype=np.float32)
