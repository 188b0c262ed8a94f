"""Work side by side: the one place that starts worker processes, and the one way in which they stop.

``nodes.children`` starts processes too, but those are the graph's nodes: each is another program that lives on its own,
is watched and restarted, and answers to ROS and not to a question.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import connection, get_context
from typing import Protocol, TypeVar

from roadmend.core.errors import SimulationError

Question = TypeVar("Question")
Answer = TypeVar("Answer")

_AGAIN = "a worker process died; run the same command again to go on"
_NEVER = (
    "a worker process died before any had answered; run the same command again, and if that is a script of your own, let "
    "it ask for workers under 'if __name__ == \"__main__\":' only"
)
_GRACE = 5.0  # [s] that work under way has to come to its end when the rest is given up


class Mapper(Protocol):
    """The built-in ``map`` for one iterable, perhaps in other processes.

    ``map`` itself is one, and so is the method of any ``concurrent.futures.Executor``: a cluster's engine that gives
    such an executor (Dask's ``Client.get_executor``) serves wherever a mapper is asked for.
    """

    def __call__(self, function: Callable[[Question], Answer], questions: Iterable[Question], /) -> Iterator[Answer]:
        """One answer a question, in the order of the questions, each as soon as it is there."""


@contextmanager
def fan_out(workers: int, most: int | None = None) -> Iterator[Mapper]:
    """A mapper over processes of this machine; what it answers does not depend on their number.

    With more than one worker, functions, questions and answers travel by pickle. When the block ends early, by an
    interrupt or an error, what was not begun is dropped, and what is under way is ended if it takes too long.

    Args:
        workers: processes; 1 is this process.
        most: of them that there is work for.

    Raises:
        SimulationError: a worker process died.
    """
    workers = workers if most is None else min(workers, most)
    if workers <= 1:
        yield map
        return
    leash, end = connection.Pipe(duplex=False)
    context = get_context("spawn")  # libsumo holds one simulation a process
    pool = ProcessPoolExecutor(workers, context, _begin_worker, (leash,))
    give_up = threading.Timer(_GRACE, end.close)
    has_answered = False

    def mapper(function: Callable[[Question], Answer], questions: Iterable[Question]) -> Iterator[Answer]:
        return heard(pool.map(function, questions))  # asked now, and not when the first answer is waited for

    def heard(answers: Iterator[Answer]) -> Iterator[Answer]:
        nonlocal has_answered
        for answer in answers:
            has_answered = True
            yield answer

    try:
        yield mapper
    except BaseException as error:
        give_up.start()
        if isinstance(error, BrokenProcessPool):
            raise SimulationError(_AGAIN if has_answered else _NEVER) from None
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        give_up.cancel()
        if give_up.ident is not None:
            give_up.join()  # it may be closing the same end at this moment
        leash.close()
        end.close()


def _begin_worker(leash: connection.Connection) -> None:
    """What a worker does first: it leaves interrupts to its parent, and sees to it that it ends when the parent does.

    Workers wait for each other's queue: of a parent that was killed they would not hear, and work on.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears it and ends the pool
    threading.Thread(target=_end_with_parent, args=(leash,), daemon=True).start()


def _end_with_parent(leash: connection.Connection) -> None:
    """Nothing is ever written on the leash: it can be read when its other end is closed, or its holder gone."""
    connection.wait([leash])
    os._exit(1)
