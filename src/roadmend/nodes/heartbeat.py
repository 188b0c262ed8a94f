"""Signs of life: a node's loop touches a file, and the launcher, which is no node, sees who does so no more.

A process that is stopped, or whose callback never returns, is there as before and answers nobody. No message shows it,
since before the first one there is none to miss; that its loop does not come round does.
"""

import contextlib
import os
import time
from dataclasses import dataclass
from pathlib import Path

HEARTBEAT_FILE = (
    "ROADMEND_HEARTBEAT_FILE"  # environment variable with the place of the file; without it none is touched
)
PERIOD_S = 0.25  # [s] between two beats
SETTLED_BEATS = 12  # three seconds of them: the first tick has come in by then, and been answered
AWAKE_S = 0.5  # [s] longest time between two looks that counts: what the launcher has slept is nobody's silence


class Heartbeat:
    """A node's side."""

    def __init__(self) -> None:
        self._path = os.environ.get(HEARTBEAT_FILE, "")
        self._last = -PERIOD_S

    def beat(self) -> None:
        """To be called each time the node's loop comes round."""
        if not self._path:
            return
        now = time.monotonic()
        if now - self._last >= PERIOD_S:
            self._last = now
            with contextlib.suppress(OSError):  # the launcher has gone, and its folder with it
                Path(self._path).touch()


@dataclass(slots=True)
class Pulse:
    """The launcher's side.

    Attributes:
        path: the file.
        beats: how many were seen.
        silence: [s] without one, as far as somebody looked.
    """

    path: Path
    beats: int = 0
    silence: float = 0.0
    _seen: int = 0  # [ns] when the file was touched last
    _looked: float | None = None  # [s]

    @property
    def is_settled(self) -> bool:
        """Whether the loop has come round so often that the long work of a start, compiling say, is behind it."""
        return self.beats >= SETTLED_BEATS

    def begin(self) -> None:
        """A new process is about to start."""
        self.path.unlink(missing_ok=True)
        self.beats, self.silence, self._seen, self._looked = 0, 0.0, 0, None

    def look(self, now: float) -> None:
        """Look, at wall time ``now`` [s], whether there was a beat since."""
        passed = 0.0 if self._looked is None else min(now - self._looked, AWAKE_S)
        self._looked = now
        try:
            touched = self.path.stat().st_mtime_ns
        except OSError:
            touched = 0
        if touched != self._seen:
            self._seen, self.beats, self.silence = touched, self.beats + 1, 0.0
        else:
            self.silence += passed
