"""In which frame messages say that they are: what is in another one is not used, and named."""

import struct
from collections.abc import Mapping

from roadmend.recording.messages import MAP_FRAME

_LENGTH = struct.Struct("<I")
_AT = 12  # [bytes] CDR's own header and the stamp; then the frame's length, with its final zero, and the frame


def frame_of(data: bytes) -> str:
    """The header's frame_id of a message that begins with a header; empty where the bytes are no such message."""
    try:
        (length,) = _LENGTH.unpack_from(data, _AT)
        return bytes(data[_AT + 4 : _AT + 3 + length]).decode("utf-8", "replace") if length else ""
    except struct.error:
        return ""


class FrameCheck:
    """Keeps who speaks of another frame. A message that names none is taken to be in the right one."""

    def __init__(self, frame: str = MAP_FRAME) -> None:
        self.frame = frame
        self.faults: dict[str, str] = {}  # part of a tick -> the foreign frame of its last message
        self.seen: dict[str, str] = {}  # the same of all that ever came

    def is_foreign(self, part: str, data: bytes) -> bool:
        """Whether a message that has just come is in another frame."""
        frame = frame_of(data)
        if frame in ("", self.frame):
            if self.faults:
                self.faults.pop(part, None)
            return False
        self.faults[part] = self.seen[part] = frame
        return True

    @property
    def warning(self) -> str:
        """What is in which frame, for people; empty where all is as it should be."""
        return self._words(self.faults)

    @property
    def account(self) -> str:
        """The same of all that ever came, for the result of a run."""
        return self._words(self.seen)

    def _words(self, faults: Mapping[str, str]) -> str:
        told = ", ".join(f"{part} in {frame!r}" for part, frame in sorted(faults.items()))
        return f"not used, since it is not in the frame {self.frame!r}: {told}" if told else ""
