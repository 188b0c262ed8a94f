"""Finished pieces of a benchmark on disk, so that an interrupted run goes on where it stopped."""

import fcntl
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from roadmend.core.errors import InputError
from roadmend.world.network import cache_folder

FORMAT = "roadmend-benchmark-work/1"
RESULTS = "results.jsonl"


class ResultStore:
    """One JSON line a finished piece, by a key that says all that decided it; one process at a time.

    Lines are only ever added, each with one write; a line that an interruption cut short is dropped at the next
    opening. A piece that was decided by anything else (another model, another parameter, other code) has another key
    and is not found.
    """

    def __init__(self, folder: Path) -> None:
        """Open a folder, or make it.

        Raises:
            InputError: the folder holds something else, is in use, damaged, or cannot be written.
        """
        self.folder = folder
        path = folder / RESULTS
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not path.exists() and any(folder.glob("[!.]*")):
                raise InputError(str(folder), "holds no benchmark's work and is not empty", "choose another folder")
            self._file = path.open("a+b", buffering=0)
        except OSError as error:
            raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose a writable folder") from None
        try:
            self._results = self._lock_and_read(path)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __len__(self) -> int:
        return len(self._results)

    def get(self, key: str) -> dict[str, Any] | None:
        """The result with this key, as it was given."""
        return self._results.get(key)

    def add(self, key: str, result: Mapping[str, Any]) -> None:
        """Keep a result.

        Raises:
            InputError: the disk is full or gone.
        """
        self._write({"key": key, "result": result})
        self._results[key] = dict(result)

    def _write(self, content: Mapping[str, Any]) -> None:
        try:
            self._file.write((json.dumps(content) + "\n").encode())
        except OSError as error:
            raise InputError(str(self.folder), f"cannot be written ({error.strerror})", "make room") from None

    def _lock_and_read(self, path: Path) -> dict[str, dict[str, Any]]:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            mend = "wait for it to end or name another folder with --work"
            raise InputError(str(self.folder), "another benchmark is at work here", mend) from None
        self._file.seek(0)
        content = self._file.readall() or b""
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            self._file.truncate(len(whole))
        results: dict[str, dict[str, Any]] = {}
        for number, line in enumerate(whole.splitlines(), 1):
            try:
                entry = json.loads(line)
                if number == 1 and entry["format"] != FORMAT:
                    raise InputError(str(path), f"is not of the format {FORMAT}", "choose another folder")
                if number > 1:
                    results[str(entry["key"])] = dict(entry["result"])
            except (ValueError, TypeError, KeyError):
                raise InputError(f"{path} line {number}", "is damaged", "choose another folder") from None
        if not whole:
            self._write({"format": FORMAT})
        return results


def default_work_folder() -> Path:
    """Where work is kept if no folder is given: beside the built networks."""
    return cache_folder() / "benchmarks" / "adreft"
