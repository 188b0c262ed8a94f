"""A bag that is there as a whole or not at all, and that may begin as a copy of another."""

import contextlib
import errno
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.core.whole_file import made_parents
from roadmend.recording.errors import RecordingError
from roadmend.recording.layout import FILE_RECORD
from roadmend.recording.reader import BagReader, Record
from roadmend.recording.renewal import Renewal
from roadmend.recording.writer import BagOptions, BagWriter


@contextlib.contextmanager
def new_bag(folder: Path, options: BagOptions | None = None) -> Iterator[BagWriter]:
    """A bag that is made beside its place and moved there once it is complete; nothing is left of one that fails.

    Raises:
        InputError: the folder exists already or cannot be made.
        RecordingError: a file cannot be written.
    """
    with place_for(folder) as beside, BagWriter(beside, options or BagOptions()) as writer:
        try:
            yield writer
        except BaseException:
            writer.abandon()
            raise


@contextlib.contextmanager
def place_for(folder: Path) -> Iterator[Path]:
    """A place for a folder of that name, from which it is moved once it is complete.

    Raises:
        InputError: the folder exists already or cannot be made.
        RecordingError: it cannot be moved.
    """
    if os.path.lexists(folder):  # a link to nowhere is something, too
        raise InputError(str(folder), "exists already", "choose another name or remove it")
    _remove_stale(folder)
    # Nobody else's: two processes may be told one name, and the later one finds it taken at the end.
    aside = folder.with_name(f".{folder.name}.{os.getpid()}-{secrets.token_hex(4)}.part")
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(made_parents(folder))
            aside.mkdir()
        except OSError as error:
            raise InputError(str(folder), f"cannot be made ({error.strerror})", "choose a writable folder") from error
        try:
            yield aside / folder.name
            if os.path.lexists(folder):
                raise FileExistsError(errno.EEXIST, "something of that name is there meanwhile")
            (aside / folder.name).rename(folder)
        except OSError as error:
            raise RecordingError(str(folder), f"cannot be written ({error.strerror})") from error
        finally:
            shutil.rmtree(aside, ignore_errors=True)


def _remove_stale(folder: Path) -> None:
    """Remove what a process that was killed has left of a bag of that name: nothing but the bag, half written."""
    pattern = re.compile(rf"\.{re.escape(folder.name)}\.(\d+)-[0-9a-f]{{8}}\.part")
    with contextlib.suppress(OSError):
        for aside in folder.parent.iterdir():
            match = pattern.fullmatch(aside.name)
            if match is None or aside.is_symlink() or Path("/proc", match[1]).exists():
                continue
            if {entry.name for entry in aside.iterdir()} <= {folder.name}:
                shutil.rmtree(aside, ignore_errors=True)


class BagCopy:
    """Copies a bag into another, up to one time after the other, so that what is added lies beside what was there.

    Topics, attachments and metadata are copied at once. Repair states of an earlier version become such of this one.
    """

    def __init__(self, reader: BagReader, writer: BagWriter) -> None:
        self._writer = writer
        renewal = Renewal(reader)
        for topic in reader.topics.values():
            writer.add_topic(topic.name, topic.type_name, topic.offers, renewal.definition(topic.type_name))
        for name, values in reader.metadata.items():
            if name != FILE_RECORD:
                writer.add_metadata(name, values)
        for attachment in reader.attachments.values():
            writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        self._records = renewal.records()
        self._next: Record | None = next(self._records, None)

    def until(self, time_ns: float) -> None:
        """Copy the messages up to a time [ns] that were not copied before.

        Raises:
            InputError: the bag is corrupt.
            RecordingError: the other bag cannot be written.
        """
        while self._next is not None and self._next.time_ns <= time_ns:
            one = self._next
            self._writer.write(one.topic, one.time_ns, one.data, one.publish_ns, one.sequence)
            self._next = next(self._records, None)
