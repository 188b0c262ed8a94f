"""What a worker process of a pool does first: it leaves interrupts to its parent, and ends when the parent does."""

import multiprocessing
import os
import signal
import threading
from multiprocessing import connection


def begin_worker() -> None:
    """Give this to a pool as its initializer.

    A pool's workers wait for each other's queue: of a parent that was killed they would not hear, and work on.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears it and ends the pool
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)
