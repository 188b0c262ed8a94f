"""Which messages repeat earlier ones, in a bag that is scanned file by file: what a file says, held against what was met."""

import contextlib
import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path

from roadmend.core.bounded_file import open_regular
from roadmend.core.errors import InputError
from roadmend.recording.layout import REPEATED
from roadmend.recording.mcap_file import McapFile
from roadmend.recording.reader import CORRUPT
from roadmend.recording.repeats import Repeats
from roadmend.recording.scan import NamedTexts, ScannedMessage

# By topic, what tells the messages of which a file says that they repeat.
_Claims = dict[str, Callable[[int, int], bool]]


class RepeatWatch:
    """A message repeats another where its file says so and the other was met: earlier files may have lost theirs."""

    def __init__(self) -> None:
        self._claims: _Claims = {}
        self._met: set[tuple[str, int, bytes]] = set()  # of topics that files repeat: topic, number and digest

    def begin(self, file: Path) -> None:
        """Take in what the next file's index says: one that was recovered tells of repeated messages behind them."""
        self._claims = {}
        with contextlib.suppress(InputError, *CORRUPT), open_regular(file) as stream:
            for record in McapFile(stream, str(file), is_lenient=True).metadata():
                if record.name == REPEATED:
                    self._claims = _claims_of(record.metadata)
                    return

    def hear(self, texts: NamedTexts) -> None:
        """Take in what a file without an index says before its messages."""
        if texts.name == REPEATED:
            self._claims = self._claims or _claims_of(texts.values)

    def is_repeat(self, message: ScannedMessage) -> bool:
        """Whether a message repeats one that was met; it is met from now on."""
        topic = message.topic
        if not any(offer.is_latched for offer in topic.offers):
            return False
        key = (topic.name, message.sequence, hashlib.sha256(message.data).digest())
        claim = self._claims.get(topic.name)
        is_repeat = claim is not None and claim(message.time_ns, message.sequence) and key in self._met
        self._met.add(key)
        return is_repeat


def _claims_of(values: Mapping[str, str]) -> _Claims:
    """As a file has it; nothing of a topic where that is damaged."""
    claims = {}
    for topic, text in values.items():
        with contextlib.suppress(ValueError):
            claims[topic] = Repeats.parse(text).taker()
    return claims
