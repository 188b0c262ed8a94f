"""Writing bags: rosbag2 layout, MCAP, one episode a bag."""

import contextlib
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from roadmend.core.errors import InputError
from roadmend.recording import layout
from roadmend.recording.bag_file import BagFile, Compression
from roadmend.recording.definitions import Definition, find
from roadmend.recording.enclosure import Attachment
from roadmend.recording.errors import RecordingError
from roadmend.recording.layout import REPEATED, FileSummary, TopicSummary
from roadmend.recording.qos import Qos
from roadmend.recording.repeats import Repeats

__all__ = ["BagOptions", "BagWriter", "Compression"]

_SECOND = 1_000_000_000
_UNKNOWN_DEPTH = 10  # messages; DDS does not tell the depth that a publisher in another process offers


@dataclass(frozen=True, slots=True)
class BagOptions:
    """How a bag is written."""

    compression: Compression = Compression.ZSTD
    chunk_size: int = 1 << 20  # [bytes] before compression, at which a chunk is written
    flush_interval: float = 0.25  # [s] of wall time after which a chunk is written even if it is small
    max_bagfile_size: int = 0  # [bytes] on disk beyond what each file repeats, at which the next begins; 0: never
    max_bagfile_duration: float = 0.0  # [s] of message time after which the next file begins; 0: never
    self_contained: bool = True  # each further file repeats metadata, attachments and what latched topics hold


@dataclass(slots=True)
class _Topic:
    """A topic while it is being written; its channel is registered with its first message in a file."""

    definition: Definition
    offers: tuple[Qos, ...]
    count: int = 0  # messages, repeated ones included
    sequence: int = 0
    latched: deque[tuple[bytes, int]] | None = None  # what a late joiner would get: bytes and sequence number


@dataclass(frozen=True, slots=True)
class _Repeated:
    """What of a file stands in earlier ones already."""

    size: int = 0  # [bytes]
    count: int = 0  # messages


class BagWriter:
    """Writes one bag.

    What was written more than ``flush_interval`` ago survives SIGKILL. The bag is complete, with indexes,
    statistics and ``metadata.yaml``, once ``close`` has returned. A bag that failed stays as it is, without
    ``metadata.yaml``, and takes nothing more.

    Args:
        folder: the bag's folder, which must not exist yet; its name is the bag's name.
        options: how to write.
        claimed: the folder was made for this bag by the caller, and is empty.

    Raises:
        InputError: the folder exists already, or cannot be made; or it is claimed, and missing or not empty.
    """

    def __init__(self, folder: Path, options: BagOptions = BagOptions(), *, claimed: bool = False) -> None:
        self.folder = folder
        self.bytes = 0  # of message data, before compression
        self.count = 0  # messages, without those that a further file repeats
        self._options = options
        self._topics: dict[str, _Topic] = {}
        self._metadata: dict[str, dict[str, str]] = {}
        self._attachments: dict[str, Attachment] = {}
        self._finished: list[FileSummary] = []
        self._repeated = _Repeated()
        self._max_ns = options.max_bagfile_duration * _SECOND
        try:
            _take(folder, claimed=claimed)
            self._file = self._next_file()
        except FileExistsError as error:
            raise InputError(str(folder), "exists already", "choose another name or remove it") from error
        except OSError as error:
            raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose another folder") from error
        self._flush_due = time.monotonic() + options.flush_interval
        self._open = True

    @property
    def is_open(self) -> bool:
        """Whether more can be written: false after ``close`` and after a failure."""
        return self._open

    @property
    def file(self) -> Path:
        """The file that is being written."""
        return self._file.path

    def add_topic(
        self, name: str, type_name: str, offers: Iterable[Qos] = (), definition: Definition | None = None
    ) -> None:
        """Announce a topic before its first message.

        Announcing it again before the first message replaces the offers. Later ones are left out: the channel in the
        file cannot be changed any more, and rosbags passes over a topic of which metadata.yaml says anything else.

        Args:
            name: the topic, with its namespace.
            type_name: package/msg/Name.
            offers: what the topic's publishers offer.
            definition: the type's definition; looked up among the installed packages if it is missing.

        Raises:
            InputError: no definition of the type is installed, or the topic was announced with another type.
        """
        found = definition or find(type_name)
        known = self._topics.get(name)
        if known is not None and known.definition.type_name != found.type_name:
            raise InputError(name, f"has two types, {known.definition.type_name} and {type_name}", "record one of them")
        topic = known or self._topics.setdefault(name, _Topic(found, ()))
        if topic.count:
            return
        topic.offers = tuple(offers)
        if self._options.self_contained and topic.offers and all(offer.is_latched for offer in topic.offers):
            # One queue for all publishers: the recorder is not told which of them sent a message.
            depth = sum(offer.depth or _UNKNOWN_DEPTH for offer in topic.offers)
            unlimited = any(offer.keeps_all for offer in topic.offers)
            topic.latched = deque(maxlen=None if unlimited else depth)
        else:
            topic.latched = None

    def write(
        self, topic: str, time_ns: int, data: bytes, publish_ns: int | None = None, sequence: int | None = None
    ) -> None:
        """Write one message.

        Args:
            topic: a topic that was announced.
            time_ns: simulation time [ns], which becomes the log time.
            data: the message, serialized as CDR.
            publish_ns: publish time [ns]; the log time if missing.
            sequence: the message's number; counted from 1 on each topic if missing.

        Raises:
            KeyError: the topic was not announced.
            ValueError: the time is negative.
            RecordingError: the file cannot be written, or the bag is closed.
        """
        entry = self._topics[topic]
        if not self._open:
            raise RecordingError(str(self.file), "the bag is closed")
        if time_ns < 0:
            raise ValueError(f"{topic}: time {time_ns} ns is negative")
        try:
            if self._is_full(time_ns):
                self._split(time_ns)
            if topic not in self._file.channels:
                self._file.add_channel(topic, entry.definition, entry.offers)
            entry.count += 1
            entry.sequence = number = entry.sequence + 1 if sequence is None else sequence
            self._file.write(topic, time_ns, data, time_ns if publish_ns is None else publish_ns, number)
        except OSError as error:
            raise self._failure(error) from error
        if entry.latched is not None:
            entry.latched.append((data, number))
        self.count += 1
        self.bytes += len(data)
        if time.monotonic() >= self._flush_due:
            self.flush()

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of named texts. Records of the same name add up, later values win.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        with self._failing():
            self._file.add_metadata(name, values)
        self._metadata.setdefault(name, {}).update(values)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write a file into the bag.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        attachment = Attachment(name, media_type, data)
        with self._failing():
            self._file.add_attachment(attachment)
        if self._options.self_contained:
            self._attachments[name] = attachment

    def flush(self) -> None:
        """Hand everything written so far to the operating system.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        with self._failing():
            self._file.flush()
        self._flush_due = time.monotonic() + self._options.flush_interval

    def flush_if_due(self) -> None:
        """Flush if the last time is long enough ago; for a timer, while no messages come.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        if time.monotonic() >= self._flush_due:
            self.flush()

    def split(self) -> None:
        """Complete the present file and begin the next.

        Raises:
            RecordingError: a file cannot be written, or the bag is closed.
        """
        with self._failing():
            self._split(self._file.end_ns)

    def close(self) -> None:
        """Complete the bag. Does nothing if that has happened already or the bag has failed.

        Raises:
            RecordingError: the file cannot be written.
        """
        if not self._open:
            return
        with self._failing():
            information = self._finish()
            layout.write_metadata(self.folder, information)
        self._open = False

    def abandon(self) -> None:
        """Close the bag as it is, incomplete. Does nothing if it is closed already."""
        self._open = False
        self._file.abandon()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _next_file(self) -> BagFile:
        path = self.folder / f"{self.folder.name}_{len(self._finished)}.mcap"
        return BagFile(path, self._options.compression, self._options.chunk_size)

    def _is_full(self, time_ns: int) -> bool:
        file, options = self._file, self._options
        if file.count <= self._repeated.count:
            return False
        if self._max_ns and time_ns - file.start_ns >= self._max_ns:
            return True
        return bool(options.max_bagfile_size) and file.size - self._repeated.size >= options.max_bagfile_size

    def _split(self, time_ns: int) -> None:
        """Begin the next file so that it can be played without the ones before."""
        known = [name for name in self._topics if name in self._file.channels]
        self._finish()
        self._file = self._next_file()
        if not self._options.self_contained:
            return
        for name, values in self._metadata.items():
            self._file.add_metadata(name, values)
        for attachment in self._attachments.values():
            self._file.add_attachment(attachment)
        repeated = {name: topic.latched for name, topic in self._topics.items() if topic.latched}
        if repeated:
            told = {name: Repeats(time_ns, tuple(number for _, number in held)) for name, held in repeated.items()}
            self._file.add_metadata(REPEATED, {name: str(each) for name, each in told.items()})
        for name in known:
            self._file.add_channel(name, self._topics[name].definition, self._topics[name].offers)
        for name, held in repeated.items():
            for data, sequence in held:
                self._file.write(name, time_ns, data, time_ns, sequence)
            self._topics[name].count += len(held)
        if repeated:
            self._file.flush()  # else their chunk would count as written later
        self._repeated = _Repeated(self._file.size, self._file.count)

    def _finish(self) -> dict[str, object]:
        """Complete the present file; returns the description of the bag up to here."""
        self._finished.append(self._file.summary)
        information = layout.bag_information(
            self._finished,
            [
                TopicSummary(name, topic.definition.type_name, topic.definition.type_hash, topic.offers, topic.count)
                for name, topic in self._topics.items()
            ],
        )
        self._file.flush()
        self._file.add_metadata(layout.FILE_RECORD, {"serialized_metadata": layout.as_text(information)})
        self._file.finish()
        return information

    @contextlib.contextmanager
    def _failing(self) -> Iterator[None]:
        """Refuse a closed bag; close the bag and raise a typed error where the system refuses to write."""
        if not self._open:
            raise RecordingError(str(self.file), "the bag is closed")
        try:
            yield
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> RecordingError:
        self.abandon()
        return RecordingError(str(error.filename or self.file), f"cannot be written ({error.strerror})")


def _take(folder: Path, *, claimed: bool) -> None:
    if not claimed:
        folder.mkdir(parents=True)
    elif any(folder.iterdir()):
        raise FileExistsError
