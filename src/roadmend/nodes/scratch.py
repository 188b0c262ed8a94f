"""Folders for the while of a run, which go with it even where the launcher is killed and cannot take them away."""

import contextlib
import multiprocessing
import os
import secrets
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from multiprocessing import connection
from pathlib import Path

from roadmend.nodes.children import CONTEXT, start_forked

_PATIENCE_S = 20.0  # [s] for the nodes to end after their launcher's death
_POLL_S = 0.1
_TRIES = 5  # at removing it: a node that is about to end may write yet


@contextlib.contextmanager
def scratch_folder(prefix: str) -> Iterator[Path]:
    """A new temporary folder; it is removed at the end, or by a process that waits for this one's death.

    Args:
        prefix: of its name.

    Raises:
        InputError: the folder for temporary files has too long a path.
    """
    folder = Path(tempfile.gettempdir(), f"{prefix}{secrets.token_hex(4)}")
    # The keeper comes before the folder: to start it takes a second, in which this process may be told to end, or killed.
    keeper = CONTEXT.Process(target=_remove_after, args=(str(folder),), name="tidy", daemon=True)
    with contextlib.suppress(OSError, EOFError):  # without it the folder stays where this process is killed
        start_forked(keeper)
    try:
        folder.mkdir(0o700)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        # Who writes into it yet is a node that this process has lost sight of, since what forked it was killed. Such a
        # node ends with this process, and the keeper then does what is left.
        if keeper.pid is not None and not folder.exists() and not _is_used(str(folder)):
            keeper.kill()
            keeper.join()


def _remove_after(folder: str) -> None:
    """Runs in the other process: waits until who made the folder is dead, and all who write into it have gone."""
    os.setsid()
    with Path(os.devnull).open("r+b", buffering=0) as nothing:  # who reads what the maker says shall not wait for this
        for descriptor in range(3):
            os.dup2(nothing.fileno(), descriptor)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    with contextlib.suppress(OSError):
        Path("/proc/self/comm").write_text("roadmend_tidy", encoding="ascii")
    maker = multiprocessing.parent_process()
    if maker is None:
        return
    connection.wait([maker.sentinel])
    until = time.monotonic() + _PATIENCE_S
    while _is_used(folder) and time.monotonic() < until:
        time.sleep(_POLL_S)
    for _ in range(_TRIES):
        shutil.rmtree(folder, ignore_errors=True)
        if not Path(folder).exists():
            return
        time.sleep(_POLL_S)


def _is_used(folder: str) -> bool:
    """Whether a process has its output in the folder: each node's log lies there."""
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has gone meanwhile, or is somebody else's
            if str((process / "fd" / "1").readlink()).startswith(f"{folder}/"):
                return True
    return False
