"""Where torch computes."""

from collections.abc import Iterator
from contextlib import contextmanager

import torch

from roadmend.core.errors import InputError


def choose_torch_device(name: str, threads: int) -> str:
    """Set torch up to give the same bits again, and say where it computes: "cpu" or "cuda".

    Args:
        name: auto (CUDA where it is there), cpu, cuda or cuda:N.
        threads: of the CPU; the order of sums, and so the last bits, depend on them.

    Raises:
        InputError: there is no such device here.
    """
    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(True, warn_only=True)
    if name == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    try:
        torch.zeros(1, device=name)
    except (RuntimeError, AssertionError):
        raise InputError("--device", f"{name!r} cannot be used here", "give auto, cpu or cuda") from None
    return name


@contextmanager
def one_thread() -> Iterator[None]:
    """Compute on one thread of the CPU: the same bits on every machine, however many cores it has."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
