"""Work that is kept on disk by a key that says all that decided it, so that a call that was interrupted goes on.

What was decided by anything else, another model, another parameter, other code, has another key and is not found.
"""

import fcntl
import hashlib
import json
import os
import stat
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NewType, Self

from roadmend.core.bounds import STREAM
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.core.source_digest import source_digest

Key = NewType("Key", str)
Entry = dict[str, Any]

KEY = "key"  # how a line names its entry's key; no entry has a value of that name
_CODE = "code"  # a setting of this name is a digest, which tells people nothing


def entry_key(code: Iterable[str], *decided: Any) -> Key:
    """The only way to a key: SHA-256 over everything that decides an entry.

    Args:
        code: full names of the modules that make the entry; what they import counts as well. Of a policy and a repair
            method, which no module imports by itself, there is ``measures.driver.driver_key``.
        decided: digests of the models and all other inputs, as plain values.
    """
    content = json.dumps([source_digest(code), *decided], sort_keys=True)
    return Key(hashlib.sha256(content.encode()).hexdigest())


def file_of(folder: Path, key: Key, suffix: str) -> Path:
    """Where to keep what is no JSON. The name stands for the key, so a file that is there is never a stale one.

    It must be written whole or not at all (``core.whole_file``).
    """
    return folder / f"{key[:32]}{suffix}"


class InUseError(InputError):
    """Another process has the journal open."""


class Journal:
    """A file of JSON lines, open in one process at a time: the format and the settings, then one line an entry.

    Lines are only ever added, each with one write; a line that an interruption cut short is dropped at the next
    opening, once the first line has said that the file is a journal of this kind: a refused file stays as it is. Of
    entries with one key the last one counts.
    """

    def __init__(
        self, path: Path, form: str, settings: Mapping[str, Any] | None = None, *, owns_folder: bool = False
    ) -> None:
        """Open a file, or begin it.

        Args:
            path: the file.
            form: name and version of the format.
            settings: plain values that hold for all entries; a file keeps to one set of them.
            owns_folder: refuse to begin in a folder that holds something else.

        Raises:
            InUseError: another process has it open.
            InputError: it is of another format or other settings, damaged, or cannot be written.
        """
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if owns_folder and not path.exists() and any(path.parent.glob("[!.]*")):
                what = f"is not empty and holds no {path.name}"
                raise InputError(str(path.parent), what, "choose another folder")
            self._file = path.open("a+b", buffering=0)
        except OSError as error:
            raise InputError(str(path), f"cannot be written ({error.strerror})", "choose a writable folder") from None
        try:
            self._entries = self._lock_and_read({"format": form, **(settings or {})})
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __len__(self) -> int:
        return len(self._entries)

    def __iter__(self) -> Iterator[tuple[Key, Entry]]:
        """Keys and entries, the oldest first."""
        return iter(self._entries.items())

    def get(self, key: Key) -> Entry | None:
        """The entry with this key, as it was given."""
        return self._entries.get(key)

    def add(self, key: Key, entry: Mapping[str, Any]) -> None:
        """Keep an entry.

        Raises:
            InputError: the disk is full or gone.
        """
        self._write({KEY: key, **entry})
        self._entries[key] = dict(entry)

    def _write(self, content: Mapping[str, Any]) -> None:
        line = _line(content)
        try:
            fits = self._file.write(line) == len(line)
        except OSError as error:
            raise InputError(str(self.path), f"cannot be written ({error.strerror})", "make room") from None
        if not fits:
            raise InputError(str(self.path), "cannot be written (the disk is full)", "make room")

    def _lock_and_read(self, head: Mapping[str, Any]) -> dict[Key, Entry]:
        if not stat.S_ISREG(os.fstat(self._file.fileno()).st_mode):
            raise InputError(str(self.path), "is a device, pipe or socket, not a file", "choose another folder")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            mend = "wait for it to end, or choose another folder"
            raise InUseError(str(self.path.parent), "another process is at work here", mend) from None
        self._file.seek(0)
        content = self._file.readall() or b""
        whole = content[: content.rfind(b"\n") + 1]
        if not whole and not _line(head).startswith(content):  # somebody's file without a line end, no head cut short
            raise self._other(head)
        entries: dict[Key, Entry] = {}
        for number, line in enumerate(whole.splitlines(), 1):
            try:
                values = parse_json(line, self.path.name, STREAM)
            except InputError:
                raise self.damaged(number) from None
            try:
                if number == 1:
                    self._check(values, head)
                else:
                    entries[Key(values.pop(KEY))] = values
            except (TypeError, KeyError, AttributeError):
                raise self.damaged(number) from None
        if len(whole) < len(content):
            self._file.truncate(len(whole))
        if not whole:
            self._write(head)
        return entries

    def damaged(self, number: int) -> InputError:
        """The error that names a line, from 1, that is not what it should be."""
        return InputError(f"{self.path} line {number}", "is damaged", "choose another folder")

    def _check(self, found: Mapping[str, Any], head: Mapping[str, Any]) -> None:
        if found.get("format") != head["format"]:
            raise self._other(head)
        for name in {**found, **head}:
            if found.get(name) != head.get(name):
                what = f"holds work with {name} {found.get(name)!r}, not {head.get(name)!r}"
                if name == _CODE:
                    what = "holds work of other code, or of another model"
                raise InputError(str(self.path), what, "choose another folder or the same settings")

    def _other(self, head: Mapping[str, Any]) -> InputError:
        return InputError(str(self.path), f"is not of the format {head['format']}", "choose another folder")


def _line(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content) + "\n").encode()
