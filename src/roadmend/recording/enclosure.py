"""What goes into a bag besides messages: files and named texts."""

import json
import mimetypes
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from roadmend.core.errors import InputError

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
        return cls(path.name, guess or "application/octet-stream", _read(path))


def metadata_from_file(path: Path) -> dict[str, str]:
    """Named texts from a file with one JSON object; values that are no texts become JSON texts.

    Raises:
        InputError: the file cannot be read or is something else.
    """
    mend = "write one JSON object"
    try:
        values = json.loads(_read(path))
    except ValueError as error:
        raise InputError(str(path), f"is not JSON ({error})", mend) from error
    if not isinstance(values, dict):
        raise InputError(str(path), "holds no JSON object", mend)
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in values.items()}


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "name a file that can be read") from error
