"""Repair states of earlier versions as those of this one, where both would else stand in one bag or on one topic."""

from collections.abc import Collection, Iterator
from dataclasses import replace

from roadmend.recording import messages
from roadmend.recording.codec import encode
from roadmend.recording.definitions import Definition, computed_hash, find
from roadmend.recording.reader import BagReader, Record
from roadmend.recording.topics import REPAIR_STATE, TYPES


class Renewal:
    """Hands on the messages of a bag: bytes as they are, but repair states by the definition that is installed.

    Args:
        reader: the bag.
    """

    def __init__(self, reader: BagReader) -> None:
        self._reader = reader
        kind = TYPES[REPAIR_STATE]
        recorded = reader.definitions.get(kind)
        self._renewed = None if recorded is None or is_installed(recorded) else kind

    def definition(self, type_name: str) -> Definition:
        """By which the messages of a type are handed on."""
        return find(type_name) if type_name == self._renewed else self._reader.definitions[type_name]

    def records(self, topics: Collection[str] | None = None) -> Iterator[Record]:
        """The messages in the order of ``BagReader.records``.

        Args:
            topics: the topics to hand on; all if missing.

        Raises:
            InputError: the bag is corrupt.
        """
        for record in self._reader.records(topics):
            if record.type_name == self._renewed:
                told = self._reader.decode(record)
                yield replace(record, data=encode(messages.renewed_repair_message_of(told)))
            else:
                yield record


def is_installed(recorded: Definition) -> bool:
    """Whether the installed definition of a type is the one that it was recorded with, as far as the bag tells.

    Raises:
        InputError: the type is not installed, or what the bag tells cannot be used.
    """
    told = recorded.type_hash
    if not told and recorded.text:
        told = computed_hash(recorded.type_name, recorded.text, recorded.encoding)
    return not told or told == find(recorded.type_name).type_hash
