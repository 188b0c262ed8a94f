"""Node processes: started in their own session, watched, restarted, and gone when the launcher is."""

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)


@dataclass
class Child:
    """One node process and its log file."""

    name: str
    command: Sequence[str]
    log: Path
    may_restart: bool
    restarts: int = 0
    process: subprocess.Popen[bytes] | None = None
    started_at: float = field(default=0.0)

    def start(self) -> None:
        """Start the process; what it prints goes to its log."""
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, start_new_session=True,
                preexec_fn=_die_with_parent if sys.platform == "linux" else None,  # noqa: PLW1509 - no threads here
                env=os.environ | {"PYTHONUNBUFFERED": "1"},
            )  # fmt: skip
        self.started_at = time.monotonic()

    @property
    def exit_code(self) -> int | None:
        """The exit code, or None while the process runs."""
        return None if self.process is None else self.process.poll()

    def interrupt(self) -> None:
        """Ask the process to stop."""
        if self.process is not None and self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)

    def last_words(self) -> str:
        """The last line that the process printed for people."""
        try:
            lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            return ""
        spoken = [line for line in lines if line.strip() and not line.startswith((" ", "\t"))]
        return spoken[-1].removeprefix("roadmend: ") if spoken else ""


def stop(children: Sequence[Child], deadline: float) -> None:
    """Interrupt processes and wait for them; those that do not go by ``deadline`` (monotonic, [s]) are killed."""
    for child in children:
        child.interrupt()
    for child in children:
        if child.process is None:
            continue
        try:
            child.process.wait(max(0.05, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            child.process.kill()
            child.process.wait()


def _die_with_parent() -> None:
    """Runs in the child before it becomes the node: no orphans when the launcher is killed."""
    ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGTERM)
