"""Episodes side by side: a pool of processes that gives its results in the order of the questions."""

import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Protocol, TypeVar

from roadmend.core.errors import SimulationError
from roadmend.core.worker_process import begin_worker

Question = TypeVar("Question")
Answer = TypeVar("Answer")


class Mapper(Protocol):
    """The built-in ``map`` for one iterable, perhaps in other processes."""

    def __call__(self, function: Callable[[Question], Answer], questions: Iterable[Question], /) -> Iterator[Answer]:
        """One answer a question, in the order of the questions, each as soon as it is there."""


@contextmanager
def open_mapper(workers: int) -> Iterator[Mapper]:
    """A mapper; with more than one worker, functions and questions travel by pickle within this machine.

    Raises:
        SimulationError: a worker process died.
    """
    if workers == 1:
        yield map
        return
    context = multiprocessing.get_context("spawn")  # libsumo holds one simulation a process
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=begin_worker)
    try:
        yield pool.map
    except BrokenProcessPool:
        raise SimulationError("a worker process died; run the same command again to go on") from None
    finally:
        pool.shutdown(cancel_futures=True)
