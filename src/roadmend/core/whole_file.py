"""Files that are there whole or not at all, and that never take the place of what is no file."""

import errno
import os
import secrets
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from roadmend.core.errors import InputError


@contextmanager
def written_beside(path: Path) -> Iterator[Path]:
    """A place beside ``path`` to write to; the file takes ``path`` when the block ends well, and goes when it does not.

    With the file go the folders that were made for it. What is at ``path`` is replaced only where it is a file: a
    link, a device or a folder there is somebody's, and stays.

    Raises:
        InputError: the place cannot be written, or is taken by what is no file.
    """
    # Nobody else's: neither another process's nor a file that happens to be hidden there.
    beside = path.with_name(f".{path.name[:200]}.{os.getpid()}-{secrets.token_hex(4)}")
    try:
        with made_parents(path):
            _check_replaceable(path)
            try:
                yield beside
                beside.replace(path)
            finally:
                with suppress(OSError):
                    beside.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(str(path), f"cannot be written ({error.strerror})", "choose a writable folder") from None


@contextmanager
def made_parents(path: Path) -> Iterator[None]:
    """The folders above ``path`` are there within the block; those that were not go again where the block fails.

    Raises:
        OSError: one of them cannot be made.
    """
    missing = [folder for folder in path.parents if not folder.exists()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for folder in missing:
            with suppress(OSError):
                folder.rmdir()  # succeeds only where it is empty
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file as UTF-8.

    Raises:
        InputError: the place cannot be written.
    """
    write_texts(path.parent, {path.name: text})


def write_texts(folder: Path, files: Mapping[str, str]) -> None:
    """Write text files that belong together by their names; none takes its place before all are written.

    Raises:
        InputError: the folder cannot be written.
    """
    with ExitStack() as stack:
        for name, text in files.items():
            beside = stack.enter_context(written_beside(folder / name))
            beside.write_text(text, encoding="utf-8")


def _check_replaceable(path: Path) -> None:
    with suppress(FileNotFoundError):
        mode = path.lstat().st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EEXIST, "a link or a device is there, not a file")
