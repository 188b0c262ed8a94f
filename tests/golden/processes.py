"""Ways to drive episodes that differ in what the process has done before; worker processes import this by name."""

import random
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import connection, get_context
from typing import Any

import physics
from numba.core.dispatcher import Dispatcher

from roadmend.core.fanout import fan_out

Record = dict[str, object]
Kernels = dict[tuple[str, str], list[Any]]


class Clutter:
    """Leaves holes of odd sizes all over the heap, others at each call."""

    SIZES = (24, 56, 120, 520, 1000, 4000, 70_000)  # [bytes]

    def __init__(self, seed: int) -> None:
        self._numbers = random.Random(seed)
        self._kept: list[bytearray] = []

    def stir(self) -> None:
        """Allocate much, free most of it and half of what was left of earlier calls, in no order."""
        numbers = self._numbers
        sizes, odds = numbers.choices(self.SIZES, k=4000), numbers.choices(range(24), k=4000)
        made = [bytearray(size + odd) for size, odd in zip(sizes, odds, strict=True)]
        numbers.shuffle(self._kept)
        del self._kept[len(self._kept) // 2 :]
        self._kept += numbers.sample(made, 500)


def drive_in_one(episodes: Iterable[physics.Golden], seed: int) -> list[Record]:
    """All in this process, one after another, its heap in disorder."""
    clutter, found = Clutter(seed), []
    for episode in episodes:
        clutter.stir()
        found.append(physics.drive(episode))
    return found


def drive_in_workers(episodes: Iterable[physics.Golden], workers: int) -> list[Record]:
    """In the processes that trainings and searches use, several in each."""
    with fan_out(workers) as mapper:
        return list(mapper(physics.drive, episodes))


def drive_in_fresh(episodes: Iterable[physics.Golden]) -> list[Record]:
    """Each in a process that has driven none before.

    They are forked from one that has loaded the program and its compiled kernels, which would else take most of the
    time.
    """
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(_fork_each, list(episodes), _kernels()).result()


def _kernels() -> Kernels:
    """The kernels that this process has used, with the types that it used them for."""
    return {
        (module, name): each.signatures
        for module in sorted(sys.modules)
        if module.startswith("roadmend.")
        for name, each in vars(sys.modules[module]).items()
        if isinstance(each, Dispatcher) and each.signatures
    }


def _fork_each(episodes: list[physics.Golden], kernels: Kernels) -> list[Record]:
    for (module, name), signatures in kernels.items():
        __import__(module)
        for signature in signatures:
            getattr(sys.modules[module], name).compile(signature)
    context, found = get_context("fork"), []
    for episode in episodes:
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=_answer, args=(there, episode))
        process.start()
        there.close()
        found.append(here.recv())
        process.join()
    return found


def _answer(there: connection.Connection, episode: physics.Golden) -> None:
    there.send(physics.drive(episode))
