"""Records of arrays and plain values as .npz files, without pickle, whole or not at all."""

import zipfile
import zlib
from dataclasses import Field, fields
from pathlib import Path
from typing import Any, Self

import numpy as np

from roadmend.core.whole_file import written_beside


class ArrayRecord:
    """Base of dataclasses whose fields are arrays, numbers and texts, and that are kept as a .npz file each."""

    __slots__ = ()

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all.

        Raises:
            InputError: the place cannot be written.
        """
        content: dict[str, Any] = {field.name: getattr(self, field.name) for field in _fields(self)}
        with written_beside(path) as beside, beside.open("wb") as file:
            np.savez(file, allow_pickle=False, **content)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read what ``save`` wrote of this class.

        Raises:
            OSError: there is no such file.
            ValueError: it is damaged, or holds something else.
        """
        try:
            with np.load(path, allow_pickle=False) as content:
                values = {field.name: content[field.name] for field in _fields(cls)}
        except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise ValueError(f"{path} is damaged: {error!r}") from None
        return cls(**{name: value.item() if value.ndim == 0 else value for name, value in values.items()})


def _fields(record: Any) -> tuple[Field[Any], ...]:
    return fields(record)
