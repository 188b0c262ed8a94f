"""Node processes: forked from a server that has everything imported, watched, restarted, gone with the launcher.

These are no workers (``core.fanout``): each is a program of its own that runs until it is stopped, and nobody waits for
an answer from it.
"""

import importlib
import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing import connection, forkserver, resource_tracker
from multiprocessing.process import BaseProcess
from pathlib import Path

from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.extras import extra_missing
from roadmend.nodes.fault import FAULT_FILE, leave_fault, read_fault
from roadmend.nodes.heartbeat import HEARTBEAT_FILE, Pulse
from roadmend.nodes.parent_death import at_parent_death

CONTEXT = multiprocessing.get_context("forkserver")
# Imports are most of a node's start. The server does them once; each node, and each restart, is then a fork away.
CONTEXT.set_forkserver_preload(
    [f"roadmend.nodes.{module}" for module in ("fork_server", "sim", "policy", "repair", "recorder", "viz")]
)
_STARTS = 3  # tries at starting a node
_SOCKET_NAME = len("/pymp-12345678/listener-12345678")  # of the server, below the folder for temporary files
_SOCKET_PATH = 107  # bytes that Linux has for the path of a socket


def start_forked(process: BaseProcess) -> None:
    """Start a process of ``CONTEXT``, and the server that forks it if it does not run.

    The server is born with interrupts held back: they are the launcher's affair, and until the server's first line of its
    own one that the terminal sends to all would end it with a traceback. That line takes the hold away again
    (``fork_server``).

    Raises:
        InputError: the folder for temporary files has too long a path for the server's socket.
        OSError, EOFError: the server was killed; the next call starts another one.
    """
    folder = tempfile.gettempdir()
    if len(os.fsencode(folder)) + _SOCKET_NAME > _SOCKET_PATH:
        most = _SOCKET_PATH - _SOCKET_NAME
        what = f"{folder} is too long a path for the sockets of processes"
        raise InputError("TMPDIR", what, f"choose a folder whose path has at most {most} characters")
    resource_tracker.ensure_running()  # by itself: it would end the hold
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)
    process.start()


@dataclass
class Child:
    """One node process and its log file; ``environment`` goes before what the launcher has in its own."""

    name: str
    module: str
    arguments: Sequence[str]
    environment: Mapping[str, str]
    log: Path
    may_restart: bool
    restarts: int = 0
    process: BaseProcess | None = field(default=None)
    hung: str = ""  # why it was killed, if it was for want of a sign of life

    def __post_init__(self) -> None:
        self.pulse = Pulse(self.log.with_suffix(".beat"))

    def start(self) -> None:
        """Start the process; what it prints goes to its log.

        Raises:
            InputError: the folder for temporary files has too long a path.
            RoadmendError: the server that forks nodes has gone, and the one that took its place has as well.
        """
        self.fault_file.unlink(missing_ok=True)
        self.pulse.begin()
        self.hung = ""
        process = CONTEXT.Process(
            target=_become_node,
            # All of the environment as it is now: the server's own is that of the day when it started.
            args=(
                self.module,
                [self.name, *self.arguments],
                {
                    **os.environ,
                    **self.environment,
                    # What a node that is killed cannot take away goes with the folder of its log.
                    "TMPDIR": str(self.log.parent),
                    FAULT_FILE: str(self.fault_file),
                    HEARTBEAT_FILE: str(self.pulse.path),
                },
                str(self.log),
            ),
            name=self.name,
        )
        self.process = None
        for left in reversed(range(_STARTS)):
            try:
                start_forked(process)
            except (OSError, EOFError) as error:  # the server was killed; with the next call there is another one
                if not left:
                    how = str(error) or type(error).__name__
                    raise RoadmendError(f"{self.name} cannot be started ({how})") from None
            else:
                break
        self.process = process

    @property
    def exit_code(self) -> int | None:
        """The exit code (minus the signal where one ended it), or None while the process runs."""
        return None if self.process is None else self.process.exitcode

    def interrupt(self) -> None:
        """Ask the process to stop."""
        if self.process is not None and self.process.pid is not None and self.process.exitcode is None:
            os.kill(self.process.pid, signal.SIGINT)

    def kill(self, why: str) -> None:
        """End the process without asking it; ``why`` is said as its fault."""
        if self.process is not None:
            self.hung = why
            self.process.kill()
            self.process.join()

    @property
    def fault_file(self) -> Path:
        """Where the process leaves why it ends."""
        return self.log.with_suffix(".fault")

    def fault(self) -> RoadmendError:
        """Why the process has ended; its log is kept where it did not say."""
        if self.hung:
            return RoadmendError(self.hung)
        said = read_fault(self.fault_file)
        if said is not None:
            return said
        how = f"ended ({self.exit_code})"
        try:
            number, kept = tempfile.mkstemp(prefix=f"roadmend-{self.name}-", suffix=".log")
            os.close(number)
            shutil.copy(self.log, kept)
        except OSError:
            return RoadmendError(how)
        return RoadmendError(f"{how}, see {kept}")


def stop(children: Sequence[Child], deadline: float) -> None:
    """Interrupt processes and wait for them; those that do not go by ``deadline`` (monotonic, [s]) are killed."""
    for child in children:
        child.interrupt()
    for child in children:
        if child.process is None:
            continue
        child.process.join(max(0.05, deadline - time.monotonic()))
        if child.process.exitcode is None:
            child.process.kill()
            child.process.join()


def _become_node(module: str, arguments: list[str], environment: dict[str, str], log: str) -> None:
    """Runs in the child: a session, an output and an environment of its own, then the node's main."""
    os.setsid()
    # The server is deaf to it. Until the node has a handler of its own an interrupt ends it without a word, as SIGTERM
    # does: Python's handler would print a traceback.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Path("/proc/self/comm").write_text(arguments[0], encoding="ascii")  # what ps, top and pkill know it by
    at_parent_death(signal.SIGCONT)  # the server ends with the launcher; who is stopped then is woken
    threading.Thread(target=_end_with_launcher, daemon=True).start()
    with Path(log).open("ab", buffering=0) as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.environ.clear()
    os.environ.update(environment)
    tempfile.tempdir = None  # of the day when the server started, too
    try:
        node = importlib.import_module(module)
    except ModuleNotFoundError as error:
        refusal = extra_missing(error)
        print(f"roadmend: {refusal}", file=sys.stderr)
        leave_fault(refusal)
        sys.exit(2)
    sys.exit(node.main(arguments))


def _end_with_launcher() -> None:
    """Waits for the launcher's death, however it comes, and stops this process then."""
    launcher = multiprocessing.parent_process()
    if launcher is not None:
        connection.wait([launcher.sentinel])
        os.kill(os.getpid(), signal.SIGTERM)
