"""A bag that is there as a whole or not at all, and that may begin as a copy of another."""

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.recording.errors import RecordingError
from roadmend.recording.reader import BagReader, Record
from roadmend.recording.writer import BagWriter

_INSIDE = "rosbag2"  # metadata record that every writer makes anew


@contextlib.contextmanager
def new_bag(folder: Path) -> Iterator[BagWriter]:
    """A bag that is made beside its place and moved there once it is complete; nothing is left of one that fails.

    Raises:
        InputError: the folder exists already or cannot be made.
        RecordingError: the bag cannot be written.
    """
    if folder.exists():
        raise InputError(str(folder), "exists already", "choose another name or remove it")
    beside = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(beside, ignore_errors=True)  # of a call that was killed
    try:
        with BagWriter(beside / folder.name) as writer:  # the folder's name is also that of the files in it
            yield writer
        try:
            (beside / folder.name).rename(folder)
        except OSError as error:
            raise RecordingError(str(folder), f"cannot be written ({error.strerror})") from error
    finally:
        shutil.rmtree(beside, ignore_errors=True)


class BagCopy:
    """Copies a bag into another, up to one time after the other, so that what is added lies beside what was there.

    Topics, attachments and metadata are copied at once.
    """

    def __init__(self, reader: BagReader, writer: BagWriter) -> None:
        self._writer = writer
        for topic in reader.topics.values():
            writer.add_topic(topic.name, topic.type_name, topic.offers, reader.definitions[topic.type_name])
        for name, values in reader.metadata.items():
            if name != _INSIDE:
                writer.add_metadata(name, values)
        for attachment in reader.attachments.values():
            writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        self._records = reader.records()
        self._next: Record | None = next(self._records, None)

    def until(self, time_ns: float) -> None:
        """Copy the messages up to a time [ns] that were not copied before.

        Raises:
            InputError: the bag is corrupt.
            RecordingError: the other bag cannot be written.
        """
        while self._next is not None and self._next.time_ns <= time_ns:
            self._writer.write(self._next.topic, self._next.time_ns, self._next.data)
            self._next = next(self._records, None)
