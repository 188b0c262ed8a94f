"""One typed door to numba, so that the hot loops stay plain Python to readers and type checkers."""

import hashlib
import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from roadmend.core.resources import cache_folder

Function = TypeVar("Function", bound=Callable[..., Any])
Named = TypeVar("Named", bound=tuple[Any, ...])

_MARK = b"roadmend.core.jit"  # who imports this file has kernels
_PACKAGE = Path(__file__).parents[1]


def _digest() -> str:
    """Of the kernels' sources as they are now, for the name of the folder that their machine code is in.

    Numba looks only at the file of a kernel, not at those of the kernels that it calls, and would go on with stale
    code after an edit there.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for folder, _, names in sorted(os.walk(_PACKAGE)):
        for name in sorted(names):
            if name.endswith(".py"):
                content = (Path(folder) / name).read_bytes()
                if _MARK in content:
                    digest.update(content)
    return digest.hexdigest()[:16]


def _choose_cache() -> None:
    """The folder that the user has named, else one in the package, else one in the user's cache.

    Others may use the first and the last as well, so that nothing is deleted there.
    """
    name, own = f"kernels-{_digest()}", Path(__file__).parent / "__pycache__"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    places: list[Callable[[], Path]] = [partial(Path, chosen)] if chosen else [lambda: own, cache_folder]
    for place in places:
        try:
            folder = place() / name
            if folder.parent == own and not folder.exists():
                for stale in own.glob("kernels-*"):
                    shutil.rmtree(stale, ignore_errors=True)
            folder.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError):  # of who has no home there is no cache either
            continue
        if os.access(folder, os.W_OK):
            numba.config.CACHE_DIR = str(folder)
            return


_choose_cache()


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call and keep the result on disk.

    Fast-math stays off: the same inputs must give the same bits in every process.
    """
    return numba.njit(cache=True, fastmath=False, error_model="numpy")(function)  # type: ignore[no-any-return]


def unnamed(record: Named) -> Named:
    """A NamedTuple as a kernel on the hot path should get it: without its names, which the kernel gives back.

    Numba spends microseconds of every call on telling the type of a NamedTuple, and next to nothing on a tuple's.
    """
    return cast("Named", tuple(record))
