"""Bringing back what a bag that was cut or damaged still holds, as a new bag."""

import contextlib
import hashlib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from roadmend.core.bounded_file import open_regular
from roadmend.core.errors import InputError
from roadmend.recording import layout
from roadmend.recording.enclosure import Attachment
from roadmend.recording.mcap_file import McapFile
from roadmend.recording.new_bag import new_bag
from roadmend.recording.reader import CORRUPT
from roadmend.recording.repeats import Repeats
from roadmend.recording.scan import NamedTexts, Scan, ScannedMessage
from roadmend.recording.writer import BagOptions, BagWriter

RECORD = "roadmend_recovery"  # metadata record of a recovered bag
_COPY = BagOptions(flush_interval=float("inf"), self_contained=False)


@dataclass(slots=True)
class Recovery:
    """What a recovery brought back."""

    bag: str
    messages: dict[str, int] = field(default_factory=dict)  # by topic
    missing: list[str] = field(default_factory=list)  # lines for people; empty where the bag was whole

    @property
    def count(self) -> int:
        """Number of messages."""
        return sum(self.messages.values())


def recover(path: Path, out: Path, advance: Callable[[int], None] = lambda _count: None) -> Recovery:
    """Write a new bag with everything that can still be read of a bag.

    Every whole message is kept with its bytes, times and number, file by file, in the order in which it was written. What
    a further file repeats counts as repeated only where the message before it came back as well.

    Args:
        path: a bag's folder, with or without a metadata.yaml, or an .mcap file by itself.
        out: the folder of the new bag.
        advance: called with the number of bytes that were passed.

    Raises:
        InputError: there is no such bag, nothing of it can be read, or ``out`` exists already or cannot be made.
        RecordingError: the new bag cannot be written.
    """
    files, missing = files_left(path)
    recovery = Recovery(str(out), missing=missing)
    with new_bag(out, _COPY) as writer:
        copying = _Copying(writer, recovery)
        for place, file in enumerate(files):
            if place:
                writer.split()
            try:
                lines = copying.copy(file, advance)
            except InputError as error:
                if len(files) == 1:
                    raise
                lines = [error.what]
            missing += [line if len(files) == 1 else f"{file.name}: {line}" for line in lines]
        if missing and not recovery.count:
            raise InputError(str(path), f"holds no message that can be read: {missing[0]}", "take another bag")
        writer.add_metadata(RECORD, {"source": path.name, "missing": "\n".join(missing)})
    return recovery


def files_left(path: Path) -> tuple[list[Path], list[str]]:
    """The MCAP files of a bag that are still there, in order, and lines on what is not.

    Raises:
        InputError: there is no such bag, it has no file, or it is a bag of another kind.
    """
    if path.exists() and not path.is_dir() and path.name != layout.METADATA_FILE:
        return [path], []
    folder = layout.folder_of(path)
    found = sorted(folder.glob("*.mcap"), key=_natural)
    missing: list[str] = []
    try:
        named = layout.files_of(path)
    except InputError as error:
        if not found:
            raise
        missing.append(f"{layout.METADATA_FILE}: {error.what}")
        named = found
    files = [file for file in named if file.exists()]
    missing += [f"{file.name} is missing" for file in named if file not in files]
    files += [file for file in found if file not in named]
    if not files:
        raise InputError(str(path), "holds no .mcap file", "name a bag's folder or an .mcap file")
    return files, missing


def bag_size(path: Path) -> int:
    """Bytes of the files of a bag.

    Raises:
        InputError: as ``files_left``, or a file cannot be looked at.
    """
    try:
        return sum(file.stat().st_size for file in files_left(path)[0])
    except OSError as error:
        raise InputError(
            str(path), f"cannot be read ({error.strerror})", "name a bag's folder or an .mcap file"
        ) from None


class _Copying:
    """Copies file after file, and tells anew which messages repeat earlier ones: of those some may be lost."""

    def __init__(self, writer: BagWriter, recovery: Recovery) -> None:
        self._writer = writer
        self._recovery = recovery
        self._latched: set[tuple[str, int, bytes]] = set()  # what was copied of topics that files repeat

    def copy(self, file: Path, advance: Callable[[int], None]) -> list[str]:
        """Copy what one file holds; returns lines on what it does not hold any more.

        Raises:
            InputError: nothing of it can be read.
        """
        scan = Scan(file, advance)
        announced: set[str] = set()
        claimed = repeats_of(file)
        repeated: dict[str, list[ScannedMessage]] = {}
        try:
            for item in scan:
                if isinstance(item, NamedTexts):
                    if item.name == layout.REPEATED:
                        claimed = claimed or takers_of(item.values)
                    elif item.name != layout.FILE_RECORD:
                        self._writer.add_metadata(item.name, item.values)
                elif isinstance(item, Attachment):
                    self._writer.add_attachment(item.name, item.media_type, item.data)
                else:
                    if item.topic.name not in announced:
                        self._announce(item)
                        announced.add(item.topic.name)
                    if self._take(item, claimed.get(item.topic.name)):
                        repeated.setdefault(item.topic.name, []).append(item)
        finally:
            if repeated:
                told = {
                    topic: str(Repeats(those[0].time_ns, tuple(one.sequence for one in those)))
                    for topic, those in repeated.items()
                }
                self._writer.add_metadata(layout.REPEATED, told)
        return scan.report.missing

    def _announce(self, message: ScannedMessage) -> None:
        topic = message.topic
        self._writer.add_topic(topic.name, topic.definition.type_name, topic.offers, topic.definition)

    def _take(self, item: ScannedMessage, is_claimed: Callable[[int, int], bool] | None) -> bool:
        """Copy a message; whether it repeats one that was copied before."""
        topic = item.topic
        self._writer.write(topic.name, item.time_ns, item.data, item.publish_ns, item.sequence)
        self._recovery.messages[topic.name] = self._recovery.messages.get(topic.name, 0) + 1
        if not any(offer.is_latched for offer in topic.offers):
            return False
        key = (topic.name, item.sequence, hashlib.sha256(item.data).digest())
        is_repeat = is_claimed is not None and is_claimed(item.time_ns, item.sequence) and key in self._latched
        self._latched.add(key)
        return is_repeat


def repeats_of(file: Path) -> dict[str, Callable[[int, int], bool]]:
    """By topic, what a file's index says of messages that repeat earlier ones: a recovered one tells of them behind them."""
    with contextlib.suppress(InputError, *CORRUPT), open_regular(file) as stream:
        for record in McapFile(stream, str(file), is_lenient=True).metadata():
            if record.name == layout.REPEATED:
                return takers_of(record.metadata)
    return {}


def takers_of(values: Mapping[str, str]) -> dict[str, Callable[[int, int], bool]]:
    """By topic, what tells the messages that repeat earlier ones, as a file has it; nothing where it is damaged."""
    takers = {}
    for topic, text in values.items():
        with contextlib.suppress(ValueError):
            takers[topic] = Repeats.parse(text).taker()
    return takers


def _natural(path: Path) -> list[tuple[int, str]]:
    """A key that sorts NAME_10 behind NAME_9."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]
