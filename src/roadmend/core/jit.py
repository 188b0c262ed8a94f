"""One typed door to numba, so that the hot loops stay plain Python to readers and type checkers."""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])
Named = TypeVar("Named", bound=tuple[Any, ...])

_MARK = b"roadmend.core.jit"  # who imports this file has kernels
_PACKAGE = Path(__file__).parents[1]


def _cache_folder() -> Path:
    """Folder for machine code made from the kernels' sources as they are now.

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
    return Path(__file__).parent / "__pycache__" / f"kernels-{digest.hexdigest()[:16]}"


def _choose_cache() -> None:
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    folder = _cache_folder()
    try:
        if not folder.exists():
            for stale in folder.parent.glob("kernels-*"):
                shutil.rmtree(stale, ignore_errors=True)
            folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return  # an installation that cannot be written: numba falls back to a folder of the user's
    numba.config.CACHE_DIR = str(folder)


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
