"""Folders that one process makes for itself, so that it never writes into, or removes, what is another's."""

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from roadmend.core.errors import InputError


def check_name(option: str, name: str) -> None:
    """Make sure that ``name`` names something inside a folder and is not a path to elsewhere.

    Raises:
        InputError: it is empty, ".", "..", or holds a separator.
    """
    if not name or name in {".", ".."} or "/" in name or "\0" in name:
        raise InputError(option, f"{name!r} is no name for a folder", "give a name without '/', and the place apart")


def claim_folder(parent: Path, name: str) -> Path:
    """Make the folder ``name`` in ``parent``; of several processes that try, one succeeds.

    Raises:
        InputError: there is something of that name already, or it cannot be made.
    """
    folder = parent / name
    try:
        parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
    except FileExistsError as error:
        if error.filename == str(folder):
            raise InputError(str(folder), "exists already", "choose another --name or remove it") from None
        raise InputError(str(error.filename), "is no folder", "choose another folder") from None
    except OSError as error:
        raise InputError(str(folder), f"cannot be made ({error.strerror})", "choose a writable folder") from None
    return folder


def claim_numbered(parent: Path, stem: str) -> Path:
    """Make a folder named ``stem``, or ``stem-2``, ``stem-3`` and so on where that is taken.

    Raises:
        InputError: none can be made.
    """
    for number in count(1):
        name = stem if number == 1 else f"{stem}-{number}"
        if not (parent / name).exists():
            try:
                return claim_folder(parent, name)
            except InputError:
                if not (parent / name).exists():
                    raise
    raise AssertionError


@contextmanager
def claimed_bag(parent: Path, name: str, stem: Callable[[], str], *, is_wanted: bool) -> Iterator[Path | None]:
    """A folder for a bag, made by and for one run before anything starts; None where nothing is recorded.

    It goes again where the input is bad, since nothing was driven then, and where nothing was written into it.

    Args:
        parent: where it lies.
        name: of the bag; if empty, it is made of ``stem`` and the time.
        stem: how such a name begins.
        is_wanted: whether anything is recorded.

    Raises:
        InputError: the name is no name or taken, or the folder cannot be made.
    """
    if name:
        check_name("--name", name)
    if not is_wanted:
        yield None
        return
    bag = claim_folder(parent, name) if name else claim_numbered(parent, f"{stem()}-{time.strftime('%Y%m%d-%H%M%S')}")
    try:
        yield bag
    except InputError:
        shutil.rmtree(bag, ignore_errors=True)
        raise
    finally:
        with suppress(OSError):
            bag.rmdir()  # succeeds only where it is empty
