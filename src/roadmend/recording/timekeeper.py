"""Which moment of simulation time a serialized message belongs to."""

import time
from collections.abc import Callable

from roadmend.recording.definitions import Definition
from roadmend.recording.messages import stamp_of_bytes

CLOCK_TYPE = "rosgraph_msgs/msg/Clock"
_HEADER = "std_msgs/Header"
_SECOND = 1_000_000_000
# A stamp beyond this, while the clock is below it, was taken from the wall clock: simulations do not begin in 2001.
_WALL_NS = 1_000_000_000 * _SECOND


class Timekeeper:
    """Reads the stamps of serialized messages and follows the clock.

    A message with a header belongs to the header's stamp, any other to the latest time seen on the clock. A header
    that was stamped from the wall clock while the simulation's clock runs belongs to the latest clock time too: it
    would else stretch the recording over decades.

    Args:
        simulated: whether /clock rules; otherwise a message belongs to the wall time at which it came, as in a bag of
            rosbag2: what is late is late in the bag too.
    """

    def __init__(self, *, simulated: bool = True) -> None:
        self.now_ns = 0  # latest clock time [ns]
        self.wall_stamps = 0  # how many headers were stamped from the wall clock
        self._simulated = simulated

    def rule_for(self, definition: Definition) -> Callable[[bytes], int]:
        """The function that gives a message of this type its time [ns] from its serialized bytes.

        It raises ValueError where they are too few to hold the stamp of one.
        """
        if definition.type_name == CLOCK_TYPE:
            return self._of_clock
        if self._simulated and definition.first_field == _HEADER:
            return self._of_header
        return self._of_bare

    def _of_clock(self, data: bytes) -> int:
        self.now_ns = max(stamp_of_bytes(data), 0)
        return self.unstamped()

    def _of_header(self, data: bytes) -> int:
        stamp = stamp_of_bytes(data)
        if stamp < 0:  # nobody has stamped it
            return self.unstamped()
        if stamp >= _WALL_NS > self.now_ns:
            self.wall_stamps += 1
            return self.now_ns
        return stamp

    def _of_bare(self, _data: bytes) -> int:
        return self.unstamped()

    def unstamped(self) -> int:
        """The time [ns] of what carries none."""
        return self.now_ns if self._simulated else time.time_ns()
