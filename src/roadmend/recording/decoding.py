"""Decoding messages by the definitions that a bag carries."""

from typing import Any

from rosbags.typesys import Stores, get_typestore

from roadmend.core.errors import InputError
from roadmend.recording.definitions import ENCODINGS, Definition


class Decoder:
    """Turns CDR into objects with the fields of the ROS type, arrays as numpy arrays."""

    def __init__(self) -> None:
        self._store = get_typestore(Stores.EMPTY)

    def decode(self, definition: Definition, data: bytes) -> Any:
        """One message.

        Raises:
            InputError: the bytes are no such message, or the definition cannot be used.
        """
        try:
            known = self._store.fielddefs
            if definition.type_name not in known:
                types = ENCODINGS[definition.encoding](definition.text, definition.type_name)
                self._store.register({name: one for name, one in types.items() if name not in known})
            return self._store.deserialize_cdr(data, definition.type_name)
        except Exception as error:  # the parser and the generated decoders raise whatever they stumble over
            raise InputError(definition.type_name, "a message is none of that type", "take another bag") from error
