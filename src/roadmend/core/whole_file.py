"""Files that are there whole or not at all."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from roadmend.core.errors import InputError


@contextmanager
def written_beside(path: Path) -> Iterator[Path]:
    """A place beside ``path`` to write to; the file takes ``path`` when the block ends well, and goes when it does not.

    Raises:
        InputError: the place cannot be written.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield beside
        beside.replace(path)
    except OSError as error:
        raise InputError(str(path), f"cannot be written ({error.strerror})", "choose a writable folder") from None
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8.

    Raises:
        InputError: the place cannot be written.
    """
    with written_beside(path) as beside:
        beside.write_text(text, encoding="utf-8")


def write_texts(folder: Path, files: Mapping[str, str]) -> None:
    """Write text files that belong together by their names; none takes its place before all are written.

    Raises:
        InputError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / f".{name}").write_text(text, encoding="utf-8")
        for name in files:
            (folder / f".{name}").replace(folder / name)
    except OSError as error:
        raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose a writable folder") from None
