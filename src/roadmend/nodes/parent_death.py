"""What a process is sent when its parent dies, however that comes; even while it is stopped."""

import ctypes
import os
import signal

_SET_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of <sys/prctl.h>


def at_parent_death(number: signal.Signals) -> None:
    """Have the kernel send this process a signal when the thread that started it ends (``man 2 prctl``).

    A stopped process (SIGSTOP) notices nothing by itself: SIGCONT wakes it, so that it can see what has happened. Left
    behind, it would hold Fast DDS's shared memory from every graph after it.

    Raises:
        OSError: the kernel refuses.
    """
    system = ctypes.CDLL(None, use_errno=True)
    if system.prctl(_SET_PARENT_DEATH_SIGNAL, int(number)):
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error))
