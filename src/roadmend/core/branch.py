"""Tries something out from where this process stands: a copy of the process does it, and the process stays as it was.

A simulation of SUMO's cannot be saved to the bit, but a process can be copied: memory, random numbers and all. The copy
shares the memory's pages until it writes to them, so that it costs a few milliseconds. For work that waits for no other
thread: of a process that is copied, only the thread that asks lives on in the copy.
"""

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import NoReturn, TypeVar

from roadmend.core.errors import RoadmendError, SimulationError

Answer = TypeVar("Answer")


def branch(work: Callable[[], Answer]) -> Answer:
    """What ``work`` comes to in a copy of this process; the answer travels by pickle.

    Raises:
        RoadmendError: the work raised it.
        SimulationError: the work raised something else, or the copy died.
    """
    reader, writer = Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        _answer(work, writer)
    writer.close()
    try:
        answer, error = reader.recv()
    except EOFError:
        raise SimulationError("the copy of the process in which a future was tried out died") from None
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        reader.close()
        os.waitpid(child, 0)
    if error is not None:
        raise error
    given: Answer = answer
    return given


def _answer(work: Callable[[], Answer], writer: Connection) -> NoReturn:
    """Do the work and end this process, whatever happens: nothing of the parent's may be tidied up here."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears it
        told: tuple[Answer | None, RoadmendError | None]
        try:
            told = work(), None
        except RoadmendError as error:
            told = None, error
        except Exception as error:  # noqa: BLE001 - the parent tells it
            told = None, SimulationError(" ".join(f"{type(error).__name__}: {error}".split()))
        with suppress(OSError):  # nobody listens any more
            writer.send(told)
    finally:
        os._exit(0)
