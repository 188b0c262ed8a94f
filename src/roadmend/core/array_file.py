"""Records of arrays and plain values as .npz files, without pickle, whole or not at all."""

import zipfile
import zlib
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from roadmend.core.whole_file import written_beside

Record = TypeVar("Record")


def save_record(path: Path, record: Any) -> None:
    """Write a dataclass whose fields are arrays, numbers and texts.

    Raises:
        InputError: the place cannot be written.
    """
    content: dict[str, Any] = {field.name: getattr(record, field.name) for field in fields(record)}
    with written_beside(path) as beside, beside.open("wb") as file:
        np.savez(file, allow_pickle=False, **content)


def load_record(path: Path, kind: type[Record]) -> Record:
    """Read what ``save_record`` wrote of a dataclass of this kind.

    Raises:
        OSError: there is no such file.
        ValueError: it is damaged, or holds something else.
    """
    try:
        with np.load(path, allow_pickle=False) as content:
            values = {field.name: content[field.name] for field in fields(kind)}  # type: ignore[arg-type]
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{path} is damaged: {error!r}") from None
    return kind(**{name: value.item() if value.ndim == 0 else value for name, value in values.items()})
