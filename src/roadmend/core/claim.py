"""Folders that one process makes for itself, so that it never writes into, or removes, what is another's."""

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
