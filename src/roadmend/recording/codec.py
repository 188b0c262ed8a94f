"""Messages as values, and as bytes (CDR), by their definitions. Needs no ROS."""

import sys
from functools import cached_property
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from roadmend.recording.definitions import ENCODINGS, Definition, find

_BYTES = {"byte": "uint8", "char": "uint8"}  # ROS's names for them; numpy has others
_TEXTS = frozenset({"string", "wstring"})
_TEXT_MAX = 200_000  # [characters] of a definition with its dependencies; the longest known has 20,000


class Codec:
    """Turns messages into bytes and back. Of one type the first definition holds.

    A message is any object with the fields of its type as attributes: numbers, texts, lists of texts and of messages,
    and contiguous arrays of numbers as numpy has them, of the definition's own number type.
    """

    def __init__(self) -> None:
        self._store = get_typestore(Stores.EMPTY)

    def encode(self, definition: Definition, message: Any) -> bytes:
        """The bytes of one message: the same ones for equal messages, without padding behind the last field."""
        self._learn(definition)
        return bytes(self._store.serialize_cdr(message, definition.type_name))

    def decode(self, definition: Definition, data: bytes, *, strict: bool = True) -> Any:
        """One message; its arrays cannot be written to.

        Args:
            definition: of its type.
            data: its bytes.
            strict: refuse bytes behind the last field; rclpy leaves some there, and does not mind them.

        Raises:
            ValueError: the bytes are no such message, or the definition cannot be used.
        """
        name = definition.type_name
        try:
            self._learn(definition)
            if strict:
                return self._store.deserialize_cdr(data, name)
            kind = self._store.get_msgdef(name)
            read = {b"\x00\x01": kind.deserialize_cdr_le, b"\x00\x00": kind.deserialize_cdr_be}[data[:2]]
            return read(data[4:], 0, kind.cls, self._store)[0]
        except Exception as error:  # the parser and the generated decoders raise whatever they stumble over
            raise ValueError(f"the bytes are no {name}") from error

    def class_of(self, definition: Definition) -> tuple[type[Any], dict[str, Any]]:
        """The class of a type's messages, and the values of a message of it in which nothing is said."""
        self._learn(definition)
        name = definition.type_name
        return self._store.types[name], {field: self._zero(*node) for field, node in self._store.fielddefs[name][1]}

    def _learn(self, definition: Definition) -> None:
        known = self._store.fielddefs
        if definition.type_name not in known:
            if len(definition.text) > _TEXT_MAX:
                raise ValueError(f"the definition of {definition.type_name} is {len(definition.text)} characters long")
            types = ENCODINGS[definition.encoding](definition.text, definition.type_name)
            self._store.register({name: one for name, one in types.items() if name not in known})

    def _zero(self, node: Nodetype, detail: Any) -> Any:
        if node == Nodetype.NAME:
            fields = self._store.fielddefs[detail][1]
            return self._store.types[detail](**{name: self._zero(*inner) for name, inner in fields})
        if node == Nodetype.BASE:
            return "" if detail[0] in _TEXTS else np.zeros((), _BYTES.get(detail[0], detail[0])).item()
        inner, count = detail
        count = count if node == Nodetype.ARRAY else 0
        if inner[0] == Nodetype.BASE and inner[1][0] not in _TEXTS:
            return np.zeros(count, _BYTES.get(inner[1][0], inner[1][0]))
        return [self._zero(*inner) for _ in range(count)]


_OURS = Codec()


class MessageType:
    """Makes and reads the messages of one type. Its definition is looked up with the first of them.

    Messages are values: what a new one does not say is shared with others, and must not be changed in place.

    Args:
        name: package/msg/Name.
    """

    def __init__(self, name: str) -> None:
        self.name = sys.intern(name)

    def __call__(self, **fields: Any) -> Any:
        """A message; fields that are not given are zero, empty or false."""
        kind, zeros = self._class
        return kind(**(zeros | fields))

    def decode(self, data: bytes) -> Any:
        """A message from its bytes, as they come over the wire; its arrays cannot be written to.

        Raises:
            ValueError: the bytes are no such message.
        """
        return _OURS.decode(self._definition, data, strict=False)

    @cached_property
    def _definition(self) -> Definition:
        return find(self.name)

    @cached_property
    def _class(self) -> tuple[type[Any], dict[str, Any]]:
        return _OURS.class_of(self._definition)


def type_of(message: Any) -> str:
    """The type of a message as package/msg/Name."""
    return str(message.__msgtype__)


def encode(message: Any) -> bytes:
    """The bytes of a message that a ``MessageType`` has made or read, or that was read from a bag."""
    return _OURS.encode(find(type_of(message)), message)
