"""What goes into a bag besides messages: files and named texts."""

import json
import mimetypes
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from roadmend.core.bounded_file import read_bytes
from roadmend.core.bounds import TEXT
from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json

_MEDIA_TYPES = {".yaml": "application/yaml", ".yml": "application/yaml"}  # unknown to mimetypes in Python 3.11


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file that a bag carries."""

    name: str
    media_type: str
    data: bytes

    @classmethod
    def from_file(cls, path: Path) -> Self:
        """A file of the disk under its own name, without its folder.

        Raises:
            InputError: it cannot be read.
        """
        guess = _MEDIA_TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0]
        content = read_bytes(path, TEXT, "name a file that can be read")
        return cls(path.name, guess or "application/octet-stream", content)


def metadata_from_file(path: Path) -> dict[str, str]:
    """Named texts from a file with one JSON object; values that are no texts become JSON texts.

    Raises:
        InputError: the file cannot be read or is something else.
    """
    mend = "write one JSON object"
    values = read_json(path, mend=mend)
    if not isinstance(values, dict):
        raise InputError(str(path), "holds no JSON object", mend)
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in values.items()}
