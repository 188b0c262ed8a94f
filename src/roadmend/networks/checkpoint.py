"""Networks as files: safetensors with a JSON header, from which nothing is ever run; and those that come with roadmend."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from safetensors import SafetensorError

from roadmend.core.bounded_file import read_bytes
from roadmend.core.bounds import MODEL
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.core.resources import config_folder
from roadmend.core.whole_file import written_beside

FORMAT = "roadmend-model/1"
REQUIRED = ("kind", "configuration", "data_digest", "metrics", "ancestry")  # what a header has besides its format
_KEY = "roadmend"  # of the file's metadata
_CHECKSUM = "checksum"  # of the header, added and taken away here

Tensors = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A model file, read."""

    tensors: dict[str, NDArray[Any]]
    header: dict[str, Any]
    digest: str  # SHA-256 of the file, in hex


def save_checkpoint(path: Path, tensors: Tensors, header: Mapping[str, Any]) -> str:
    """Write a model file, whole or not at all; the same content always gives the same bytes.

    Args:
        path: the file; its folder is made.
        tensors: by name, of any shape, of a bool, integer or float type.
        header: what JSON can hold, with at least the keys REQUIRED: the kind of model ("adreft", "neural", ...), its
            training configuration, the digest of the data that it was trained on, its metrics, and the digests of the
            models that it was made from. "format" is added.

    Returns:
        The digest of the file, as load_checkpoint gives it.

    Raises:
        InputError: the file cannot be written.
        ValueError: the header lacks a key, or holds what JSON cannot (NaN among it).
    """
    missing = [key for key in REQUIRED if key not in header]
    if missing:
        raise ValueError(f"the header of a model lacks {', '.join(missing)}")
    arrays = {name: np.ascontiguousarray(tensors[name]) for name in sorted(tensors)}
    whole = json.loads(json.dumps({**header, "format": FORMAT}, allow_nan=False))  # as it will be read: tuples as lists
    whole[_CHECKSUM] = _checksum(whole, arrays)
    data = safetensors.numpy.save(arrays, {_KEY: _canonical(whole)})
    with written_beside(path) as beside:
        beside.write_bytes(data)
    return hashlib.sha256(data).hexdigest()


def load_checkpoint(path: Path, kind: str | None = None) -> Checkpoint:
    """Read a model file.

    Args:
        path: the file.
        kind: refuse any other kind of model.

    Raises:
        InputError: the file is missing, cut, changed since it was saved, none of ours, or of another format or kind.
    """
    where = str(path)
    data = read_bytes(path, MODEL, "name a model file (.safetensors)")
    mend = "give a model that roadmend saved, or train it again"
    try:
        header = _read_header(data, where)
        tensors = safetensors.numpy.load(data)
        checksum = _checksum({name: value for name, value in header.items() if name != _CHECKSUM}, tensors)
    except (SafetensorError, InputError, ValueError, LookupError, TypeError, AttributeError, OverflowError) as error:
        raise InputError(where, "is no model file, or is cut or damaged", mend) from error
    if header.get("format") != FORMAT:
        found = header.get("format", "no format")
        raise InputError(where, f"has the format {found!r}, not {FORMAT!r}", "use the roadmend that saved it")
    if header.pop(_CHECKSUM, None) != checksum or any(key not in header for key in REQUIRED):
        raise InputError(where, "was changed or damaged since it was saved", mend)
    if kind is not None and header.get("kind") != kind:
        raise InputError(where, f"is a model of the kind {header.get('kind')!r}", f"give one of the kind {kind!r}")
    return Checkpoint(tensors, header, hashlib.sha256(data).hexdigest())


@cache
def _kind(path: Path, _modified: int) -> str:
    return str(load_checkpoint(path).header["kind"])


def model_kind(path: Path) -> str:
    """The kind of model that a file holds; read once for as long as the file stays as it is.

    Raises:
        InputError: as load_checkpoint.
    """
    try:
        modified = path.stat().st_mtime_ns
    except OSError:
        modified = 0  # reading it says what is wrong
    return _kind(path, modified)


def _read_header(data: bytes, where: str) -> dict[str, Any]:
    """Our header in a file that may hold anything."""
    length = int.from_bytes(data[:8], "little")
    if length > MODEL.line:
        raise ValueError(f"its header claims {length} bytes")
    header = parse_json(parse_json(data[8 : 8 + length], where, MODEL)["__metadata__"][_KEY], where, MODEL)
    if not isinstance(header, dict):
        raise TypeError("a header is a mapping")
    return header


def _canonical(value: Mapping[str, Any]) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _checksum(header: Mapping[str, Any], tensors: Tensors) -> str:
    """SHA-256 of all that a file holds: safetensors itself would not notice a changed weight."""
    value = hashlib.sha256(_canonical(header).encode())
    for name in sorted(tensors):
        array = np.ascontiguousarray(tensors[name])
        value.update(f"\0{name}\0{array.dtype.str}\0{array.shape}\0".encode())
        value.update(array.tobytes())
    return value.hexdigest()


SUFFIX = ".safetensors"


def models_folder() -> Path:
    """The folder config/models of the project.

    Raises:
        RoadmendError: config/ is neither in the source tree nor installed.
    """
    return config_folder() / "models"


def find_model(given: str, prefix: str = "") -> Path:
    """The file of a model that is given by the name of one that ships with roadmend, or as a path.

    Args:
        given: a path ends with ".safetensors"; anything else is a name.
        prefix: what the shipped file's name has before ``given``, such as "adreft-".

    Raises:
        InputError: there is no such file.
    """
    if given.endswith(SUFFIX):
        path = Path(given)
        if not path.is_file():
            raise InputError(given, "no such model file", "give the path of one, or the name of a shipped model")
        return path
    folder = models_folder()
    path = folder / f"{prefix}{given}{SUFFIX}"
    if "/" in given or not path.is_file():
        names = (file.name.removeprefix(prefix).removesuffix(SUFFIX) for file in folder.glob(f"{prefix}*{SUFFIX}"))
        # Without a prefix it is a policy's that is asked for; those of repair methods are called METHOD-POLICY.
        known = sorted(name for name in names if prefix or "-" not in name)
        choice = f"choose one of: {', '.join(known)}" if known else "train one"
        raise InputError(f"model '{given}'", f"roadmend ships no {prefix}{given}{SUFFIX}", f"{choice}, or give a path")
    return path
