"""A DDS domain of its own for every run, so that parallel runs on one machine do not hear each other."""

import contextlib
import fcntl
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from roadmend.core.errors import InputError, RoadmendError

_DOMAINS = range(1, 100)  # above 101 the ports of a domain meet Linux's ephemeral ports
_DOMAIN_MAX = 232  # beyond, the port numbers of a domain pass 65535


@contextlib.contextmanager
def own_domain() -> Iterator[int]:
    """A domain id that no other run on this machine holds; ROS_DOMAIN_ID wins where it is set.

    Raises:
        InputError: ROS_DOMAIN_ID is out of range.
        RoadmendError: all are taken.
    """
    chosen = os.environ.get("ROS_DOMAIN_ID", "")
    if chosen.isdecimal():
        if int(chosen) > _DOMAIN_MAX:
            raise InputError("ROS_DOMAIN_ID", f"{chosen} is no DDS domain", f"choose 0 to {_DOMAIN_MAX} or unset it")
        yield int(chosen)
        return
    folder = Path(tempfile.gettempdir())
    first = os.getpid()
    for step in _DOMAINS:
        number = 1 + (first + step) % len(_DOMAINS)
        with (folder / f"roadmend-domain-{os.getuid()}-{number}.lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield number
            return
    raise RoadmendError("all DDS domains are taken by other runs; end some of them or set ROS_DOMAIN_ID")
