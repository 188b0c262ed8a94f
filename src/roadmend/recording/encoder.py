"""Messages to bytes. Needs no ROS."""

from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from roadmend.recording.definitions import find


class Encoder:
    """Serializes messages as CDR, by the definitions of the installed packages.

    Whatever has the fields of a type as attributes will do: a message of rclpy as well as a decoded one. rclpy's own
    ``serialize_message`` leaves bytes behind the message that strict readers refuse, and padding that differs from call
    to call.
    """

    def __init__(self) -> None:
        self._store = get_typestore(Stores.EMPTY)

    def encode(self, type_name: str, message: Any) -> bytes:
        """The bytes of one message.

        Args:
            type_name: package/msg/Name.
            message: its fields as attributes.

        Raises:
            InputError: no such type is installed.
        """
        known = self._store.fielddefs
        if type_name not in known:
            types = get_types_from_msg(find(type_name).text, type_name)
            self._store.register({name: one for name, one in types.items() if name not in known})
        return bytes(self._store.serialize_cdr(self._plain(type_name, message), type_name))

    def _plain(self, type_name: str, message: Any) -> Any:
        _, fields = self._store.fielddefs[type_name]
        return self._store.types[type_name](
            **{name: self._value(node, detail, getattr(message, name)) for name, (node, detail) in fields}
        )

    def _value(self, node: Nodetype, detail: Any, value: Any) -> Any:
        if node == Nodetype.NAME:
            return self._plain(detail, value)
        if node == Nodetype.BASE:
            return value
        (kind, inner), _ = detail
        if kind == Nodetype.NAME:
            return [self._plain(inner, one) for one in value]
        primitive = inner[0]
        if primitive in {"string", "wstring"}:
            return list(value)
        return np.asarray(value, dtype={"byte": "uint8", "char": "uint8"}.get(primitive, primitive))
