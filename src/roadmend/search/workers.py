"""Evaluates batches of points: in this process, or side by side in others."""

import multiprocessing
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from typing import Protocol, TypeVar

from roadmend.core.errors import SimulationError
from roadmend.core.worker_process import begin_worker
from roadmend.search.evaluation import Evaluation, Subject, evaluate
from roadmend.world.space import Parameters

Item = TypeVar("Item")
Result = TypeVar("Result")
Mapped = Callable[[Iterable[Item]], Iterator[Result]]


class Evaluator(Protocol):
    """Evaluates points."""

    def __call__(self, points: Sequence[Parameters], /) -> Iterator[Evaluation]:
        """One evaluation a point, in the order of the points, each as soon as it is there."""


@contextmanager
def open_evaluator(subject: Subject, workers: int) -> Iterator[Evaluator]:
    """An evaluator; what it finds does not depend on the number of workers.

    Raises:
        SimulationError: a worker process died.
    """
    with open_map(partial(evaluate, subject), workers) as evaluator:
        yield evaluator


@contextmanager
def open_map(work: Callable[[Item], Result], workers: int) -> Iterator[Mapped[Item, Result]]:
    """Like ``map`` with one function, over ``workers`` processes; results come in the order of the items.

    Raises:
        SimulationError: a worker process died.
    """
    if workers == 1:
        yield partial(map, work)
        return
    context = multiprocessing.get_context("spawn")  # libsumo holds one simulation a process
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=begin_worker)
    try:
        yield partial(pool.map, work)
    except BrokenProcessPool:
        raise SimulationError("a worker process died; run the same command again to go on") from None
    finally:
        pool.shutdown(cancel_futures=True)
