"""Turning a bag of mcap into one of sqlite3, the storage of older rosbag2, and back."""

import sqlite3
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import apsw
from rosbags.interfaces import Connection, ConnectionExtRosbag2, MessageDefinitionFormat
from rosbags.rosbag2 import Reader, ReaderError, StoragePlugin, Writer

from roadmend.core.errors import InputError
from roadmend.recording import layout, qos
from roadmend.recording.definitions import Definition, computed_hash, find
from roadmend.recording.errors import RecordingError
from roadmend.recording.new_bag import new_bag, place_for
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagOptions

MCAP, SQLITE3 = "mcap", "sqlite3"
_HIDDEN = {layout.FILE_RECORD, layout.REPEATED}  # metadata records that are about the file itself
_SUFFIXES = {".mcap": MCAP, ".db3": SQLITE3}
_VERSION = 9
# Whatever a database that is none of rosbag2's makes the library stumble over.
_CORRUPT = (ReaderError, apsw.Error, ValueError, LookupError, TypeError, AttributeError)
_LOOSE = "custom_data"  # metadata record for what another writer left without a record's name


@dataclass(slots=True)
class Conversion:
    """What came of a conversion."""

    bag: str
    storage: str  # mcap or sqlite3
    messages: int = 0
    left_out: list[str] = field(default_factory=list)  # lines for people: what the storage has no place for


def storage_of(path: Path) -> str:
    """The storage of a bag: mcap or sqlite3.

    Args:
        path: a bag's folder, its metadata.yaml, or a file of it.

    Raises:
        InputError: there is no such bag, it is cut short, or its storage is another.
    """
    if path.is_file() and path.suffix in _SUFFIXES:
        return _SUFFIXES[path.suffix]
    storage: str = layout.read_metadata(path)["storage_identifier"]
    if storage not in {MCAP, SQLITE3}:
        raise InputError(str(path), f"the bag's storage is {storage!r}", "take one of mcap or sqlite3")
    return storage


def convert(path: Path, out: Path, storage: str, advance: Callable[[int], None] = lambda _count: None) -> Conversion:
    """Write a bag anew in another storage, with all topics, types, definitions, offers, times and bytes.

    Args:
        path: a bag's folder, its metadata.yaml, or a file of it.
        out: the folder of the new bag.
        storage: mcap or sqlite3.
        advance: called with the number of messages that were passed.

    Raises:
        InputError: there is no such bag, it cannot be read, or ``out`` exists already or cannot be made.
        RecordingError: the new bag cannot be written.
    """
    conversion = Conversion(str(out), storage)
    if storage_of(path) == storage:
        raise InputError(str(path), f"is a bag of {storage} already", "choose the other storage with --to")
    if storage == MCAP:
        _to_mcap(path if path.suffix in _SUFFIXES else layout.folder_of(path), out, conversion, advance)
    else:
        _to_sqlite3(BagReader(path), out, conversion, advance)
    return conversion


def _to_mcap(path: Path, out: Path, conversion: Conversion, advance: Callable[[int], None]) -> None:
    layout.refuse_compressed(path.parent if path.suffix in _SUFFIXES else path)
    try:
        with Reader(path) as reader, new_bag(out, BagOptions(flush_interval=float("inf"))) as writer:
            for connection in reader.connections:
                offers = connection.ext.offered_qos_profiles if isinstance(connection.ext, ConnectionExtRosbag2) else ()
                definition = _definition(connection)
                writer.add_topic(connection.topic, connection.msgtype, map(qos.from_rosbags, offers), definition)
            for key, value in (reader.storage.metadata.custom or {}).items():
                record, separator, name = key.partition("/")
                writer.add_metadata(record if separator else _LOOSE, {name if separator else key: value})
            for connection, time_ns, data in reader.messages():
                writer.write(connection.topic, time_ns, bytes(data))
                conversion.messages += 1
                advance(1)
    except _CORRUPT as error:
        raise InputError(str(path), f"cannot be read ({error})", "take another bag") from error


def _to_sqlite3(reader: BagReader, out: Path, conversion: Conversion, advance: Callable[[int], None]) -> None:
    try:
        with (
            place_for(out) as beside,
            Writer(beside, version=_VERSION, storage_plugin=StoragePlugin.SQLITE3) as writer,
        ):
            for record, values in reader.metadata.items():
                for name, value in values.items():
                    if record not in _HIDDEN:
                        writer.set_custom_data(name if record == _LOOSE else f"{record}/{name}", value)
            connections = {}
            for topic in reader.topics.values():
                definition = reader.definitions[topic.type_name]
                connections[topic.name] = writer.add_connection(
                    topic.name,
                    topic.type_name,
                    msgdef=definition.text,
                    rihs01=_hash(definition),
                    offered_qos_profiles=[qos.to_rosbags(offer) for offer in topic.offers],
                )
            counted: Counter[str] = Counter()
            lost: Counter[str] = Counter()
            for one in reader.records():
                writer.write(connections[one.topic], one.time_ns, one.data)
                conversion.messages += 1
                counted[one.topic] += 1
                lost["publish times"] += one.publish_ns != one.time_ns
                lost["sequence numbers"] += one.sequence != counted[one.topic]  # others than are counted anew
                advance(1)
    except sqlite3.Error as error:
        raise RecordingError(str(out), f"cannot be written ({error})") from error
    conversion.left_out += [f"{count} {what}: sqlite3 has no place for them" for what, count in lost.items() if count]
    conversion.left_out += [f"attachment {name}: sqlite3 has no place for it" for name in reader.attachments]


def _definition(connection: Connection) -> Definition:
    """What the bag says of a type, or for bags that do not say it, what is installed."""
    if connection.msgdef.format == MessageDefinitionFormat.NONE:
        return find(connection.msgtype)
    encoding = "ros2idl" if connection.msgdef.format == MessageDefinitionFormat.IDL else "ros2msg"
    return Definition(connection.msgtype, connection.msgdef.data, connection.digest, encoding)


def _hash(definition: Definition) -> str:
    return definition.type_hash or computed_hash(definition.type_name, definition.text, definition.encoding)
