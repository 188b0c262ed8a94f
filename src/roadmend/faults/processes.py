"""The processes of a run, as the system shows them to who did not start them."""

import contextlib
import os
import signal
import time
from pathlib import Path

_PROC = Path("/proc")


def node_process(launcher: int, node: str, patience: float) -> int | None:
    """Process id of a node: the descendant of the launcher that writes the node's log.

    Args:
        launcher: process id of ``roadmend run``.
        node: its name without "_node".
        patience: how long to look for it [s].
    """
    until = time.monotonic() + patience
    while time.monotonic() < until:
        for folder in _PROC.glob("[0-9]*"):
            with contextlib.suppress(OSError, ValueError, IndexError):
                if (folder / "fd" / "1").readlink().name == f"{node}.log" and launcher in _ancestors(int(folder.name)):
                    return int(folder.name)
        time.sleep(0.02)
    return None


def left_of(mark: str) -> list[int]:
    """Processes whose environment holds a text: what a run has left behind if it was started with that."""
    found = []
    for folder in _PROC.glob("[0-9]*"):
        with contextlib.suppress(OSError):
            is_dead = (folder / "stat").read_text().rpartition(")")[2].split()[0] in {"Z", "X"}
            if not is_dead and mark.encode() in (folder / "environ").read_bytes():
                found.append(int(folder.name))
    return [number for number in found if number != os.getpid()]


def command_of(process: int) -> str:
    """The command line of a process; empty if it has gone."""
    with contextlib.suppress(OSError):
        return (_PROC / str(process) / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()
    return ""


def end_all(mark: str) -> None:
    """Kill what ``left_of`` finds."""
    for number in left_of(mark):
        with contextlib.suppress(ProcessLookupError):
            os.kill(number, signal.SIGKILL)


def _ancestors(process: int) -> list[int]:
    found = []
    while process > 1:
        process = int((_PROC / str(process) / "stat").read_text().rpartition(")")[2].split()[1])
        found.append(process)
    return found
