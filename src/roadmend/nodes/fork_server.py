"""Imported by the server that forks nodes, ahead of all else: it ends with the launcher.

An interrupt is the launcher's and the nodes' affair: multiprocessing makes the server deaf to it only after all imports.
Up to here they were held back (``children.start_forked``), which nodes would inherit.
By itself it stays for as long as one of its nodes lives, and a node that is stopped is woken by the server's end alone
(``parent_death``).
"""

import signal

from roadmend.nodes.parent_death import at_parent_death

signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
at_parent_death(signal.SIGKILL)
