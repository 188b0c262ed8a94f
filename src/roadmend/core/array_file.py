"""Records of arrays and plain values as .npz files, without pickle, whole or not at all."""

import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import Field, fields
from pathlib import Path
from typing import Any, BinaryIO, Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.bounds import ARRAYS
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
        with opened_arrays(path) as content:
            values = {field.name: content[field.name] for field in _fields(cls)}
        return cls(**{name: value.item() if value.ndim == 0 else value for name, value in values.items()})


@contextmanager
def opened_arrays(file: Path | BinaryIO) -> Iterator[Mapping[str, NDArray[Any]]]:
    """The arrays of a .npz file by name, each read when it is asked for.

    Raises:
        OSError: there is no such file.
        ValueError: it is damaged, is none, or unpacks to more than ``bounds.ARRAYS`` allows.
    """
    try:
        content = np.load(file, allow_pickle=False)
        with content:  # of a single array, which is no archive, that is a TypeError
            _check_unpacked(content.zip)
            yield content
    except (
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        EOFError,
        MemoryError,
        OverflowError,
        RuntimeError,  # a part that is encrypted, or compressed in a way that nobody knows
        SyntaxError,  # of a header
        struct.error,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        name = file if isinstance(file, Path) else "the archive"
        raise ValueError(f"{name} is damaged: {error!r}") from None


def _check_unpacked(archive: zipfile.ZipFile) -> None:
    size = sum(part.file_size for part in archive.infolist())  # no more is ever read of a part
    if size > ARRAYS.unpacked:
        raise ValueError(f"it unpacks to {size / 1e6:.0f} MB")


def _fields(record: Any) -> tuple[Field[Any], ...]:
    return fields(record)
