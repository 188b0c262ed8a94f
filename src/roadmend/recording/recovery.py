"""Bringing back what a bag that was cut or damaged still holds, as a new bag."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.recording import layout
from roadmend.recording.enclosure import Attachment
from roadmend.recording.new_bag import new_bag
from roadmend.recording.repeat_watch import RepeatWatch
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
        if not found or layout.is_compressed(path):  # whose bytes would pass for messages that they are not
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
        self._repeats = RepeatWatch()

    def copy(self, file: Path, advance: Callable[[int], None]) -> list[str]:
        """Copy what one file holds; returns lines on what it does not hold any more.

        Raises:
            InputError: nothing of it can be read.
        """
        scan = Scan(file, advance)
        announced: set[str] = set()
        self._repeats.begin(file)
        repeated: dict[str, list[ScannedMessage]] = {}
        try:
            for item in scan:
                if isinstance(item, NamedTexts):
                    self._repeats.hear(item)
                    if item.name not in {layout.REPEATED, layout.FILE_RECORD}:
                        self._writer.add_metadata(item.name, item.values)
                elif isinstance(item, Attachment):
                    self._writer.add_attachment(item.name, item.media_type, item.data)
                else:
                    if item.topic.name not in announced:
                        self._announce(item)
                        announced.add(item.topic.name)
                    if self._take(item):
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

    def _take(self, item: ScannedMessage) -> bool:
        """Copy a message; whether it repeats one that was copied before."""
        topic = item.topic
        self._writer.write(topic.name, item.time_ns, item.data, item.publish_ns, item.sequence)
        self._recovery.messages[topic.name] = self._recovery.messages.get(topic.name, 0) + 1
        return self._repeats.is_repeat(item)


def _natural(path: Path) -> list[tuple[int, str]]:
    """A key that sorts NAME_10 behind NAME_9."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]
