"""A DDS domain of its own for every run, so that parallel runs on one machine do not hear each other."""

import contextlib
import errno
import os
import socket
from collections.abc import Iterator

from roadmend.core.errors import InputError, RoadmendError

_DOMAINS = range(1, 100)  # above 101 the ports of a domain meet Linux's ephemeral ports
_MARK = "roadmend-domain-"
_DOMAIN_MAX = 232  # beyond, the port numbers of a domain pass 65535


@contextlib.contextmanager
def own_domain(*, is_chosen: bool = True) -> Iterator[int]:
    """A domain id that no other run on this machine holds.

    What marks it as taken is the name of a socket in Linux' abstract namespace. That is one for all who share the network's
    ports, whoever they are and whatever their TMPDIR, and the name is free again when its process is gone.

    Args:
        is_chosen: whether ROS_DOMAIN_ID wins where it is set; else it is one that is not taken.

    Raises:
        InputError: ROS_DOMAIN_ID is out of range.
        RoadmendError: all are taken.
    """
    chosen = os.environ.get("ROS_DOMAIN_ID", "")
    if chosen.isdecimal():
        if int(chosen) > _DOMAIN_MAX:
            raise InputError("ROS_DOMAIN_ID", f"{chosen} is no DDS domain", f"choose 0 to {_DOMAIN_MAX} or unset it")
        if is_chosen:
            yield int(chosen)
            return
    first = os.getpid()
    for step in _DOMAINS:
        number = 1 + (first + step) % len(_DOMAINS)
        if chosen.isdecimal() and number == int(chosen):  # whoever is there has not marked it
            continue
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as mark:
            try:
                mark.bind(f"\0{_MARK}{number}")
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    raise
                continue
            yield number
            return
    mend = "end some of them" + (" or set ROS_DOMAIN_ID" if is_chosen else "")
    raise RoadmendError(f"all DDS domains are taken by other runs; {mend}")
