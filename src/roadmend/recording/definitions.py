"""Message definitions as text: as ROS packages install them, or as they come with roadmend. Needs no ROS."""

import json
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from roadmend.core.errors import InputError

_IDL_HEAD = re.compile(r"^={80}\nIDL: .*\n", re.MULTILINE)  # as rosbag2 parts the type and those that it contains
_IDL_INCLUDE = re.compile(r"^#include .*\n", re.MULTILINE)


def _types_from_idl(text: str, _type_name: str) -> Any:
    types: dict[str, Any] = {}
    for part in _IDL_HEAD.split(text):
        if part.strip():
            types |= get_types_from_idl(_IDL_INCLUDE.sub("", part))
    return types


ENCODINGS = {"ros2msg": get_types_from_msg, "ros2idl": _types_from_idl}  # of definitions, with their parsers
_PRIMITIVES = frozenset(
    {
        "bool",
        "byte",
        "char",
        "float32",
        "float64",
        "int8",
        "uint8",
        "int16",
        "uint16",
        "int32",
        "uint32",
        "int64",
        "uint64",
        "string",
        "wstring",
    }
)
_TYPE_NAME = re.compile(r"([A-Za-z]\w*)/(?:msg/)?([A-Za-z]\w*)")
# A field is a type, perhaps bounded, perhaps an array, and a name; a constant has "=" after its name.
_FIELD = re.compile(r"(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[[^\]]*\])?\s+[A-Za-z]\w*(?P<rest>.*)")
_SEPARATOR = "=" * 80


@dataclass(frozen=True, slots=True)
class Definition:
    """The complete definition of one message type."""

    type_name: str  # package/msg/Name
    text: str  # the type's own .msg text, then that of each type it contains, parted by lines of 80 "="
    type_hash: str  # RIHS01_...; empty where it is not known
    encoding: str = "ros2msg"  # of the text, as MCAP names it; rosbag2 also writes ros2idl

    @property
    def first_field(self) -> str:
        """Type of the first field as package/Name, or its primitive name; with [] if it is an array; may be empty."""
        own = self.text.split(_SEPARATOR, maxsplit=1)[0]
        return next(_fields(own, self.type_name.split("/", maxsplit=1)[0]), "")


@cache
def find(type_name: str) -> Definition:
    """The definition of a message type.

    Searches share/ of each prefix in AMENT_PREFIX_PATH, then of the running Python, then what comes with roadmend: its
    own messages and those of the packages in msg/vendor, and ROS's common ones without their comments.

    Args:
        type_name: package/msg/Name or package/Name.

    Raises:
        InputError: no such type is installed, or one that it contains is missing.
    """
    match = _TYPE_NAME.fullmatch(type_name)
    if match is None:
        raise InputError(type_name, "is not the name of a message type", "write package/msg/Name")
    short = f"{match[1]}/{match[2]}"
    texts: dict[str, str] = {}
    _collect(short, texts)
    parts = [texts.pop(short), *(f"{_SEPARATOR}\nMSG: {name}\n{text}" for name, text in texts.items())]
    full_name = f"{match[1]}/msg/{match[2]}"
    text = "\n".join(parts)
    return Definition(full_name, text, _installed_hash(full_name) or computed_hash(full_name, text))


def computed_hash(type_name: str, text: str, encoding: str = "ros2msg") -> str:
    """The type's hash (REP 2016, RIHS01) worked out from its complete definition.

    Raises:
        InputError: it cannot be parsed, or lacks a type that it contains.
    """
    store = get_typestore(Stores.EMPTY)
    try:
        store.register(ENCODINGS[encoding](text, type_name))
        return str(store.hash_rihs01(type_name))
    except Exception as error:  # the parser raises whatever it stumbles over, and says much
        what = f"lacks the type {error}" if isinstance(error, KeyError) else "cannot be parsed"
        raise InputError(
            f"definition of {type_name}", what, "give it whole, with every type that it contains"
        ) from error


def same_layout(one: Definition, other: Definition) -> bool:
    """Whether messages of one definition can be read by the other; of two types they are no matter to each other."""
    if (
        one.type_name != other.type_name
        or one.text == other.text
        or (one.type_hash and one.type_hash == other.type_hash)
    ):
        return True
    try:
        hashes = {computed_hash(each.type_name, each.text, each.encoding) for each in (one, other)}
    except InputError:  # which cannot be told
        return False
    return len(hashes) == 1


def _collect(name: str, texts: dict[str, str]) -> None:
    """Put the text of ``name`` and of all that it contains into ``texts``, in the order in which rosbag2 puts them."""
    text = _read(name)
    texts[name] = text
    contained = {field.removesuffix("[]") for field in _fields(text, name.split("/", maxsplit=1)[0])} - _PRIMITIVES
    for other in sorted(contained):
        if other not in texts:
            _collect(other, texts)


def _fields(text: str, package: str) -> Iterator[str]:
    """Types of the fields of one .msg text, array bounds dropped, names of its own package completed."""
    for line in text.splitlines():
        match = _FIELD.fullmatch(line.split("#", maxsplit=1)[0].strip())
        if match is None or match["rest"].lstrip().startswith("="):
            continue
        kind = match["type"].replace("/msg/", "/")
        if kind not in _PRIMITIVES and "/" not in kind:
            kind = f"{package}/{kind}"
        yield f"{kind}[]" if match["array"] else kind


def _read(name: str) -> str:
    for path in (*_candidates(name, ".msg"), *_shipped(name)):
        try:
            return path.read_text("utf-8")
        except FileNotFoundError:
            continue
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(str(path), f"cannot be read ({error})", "install the package anew") from error
    store, full_name = _common(), name.replace("/", "/msg/")
    if full_name not in store.fielddefs:
        raise InputError(
            name, "no such message type is installed", "install its package or add its prefix to AMENT_PREFIX_PATH"
        )
    return str(store.generate_msgdef(full_name, ros_version=2)[0]).split(f"{_SEPARATOR}\n", maxsplit=1)[0]


@cache
def _common() -> Any:
    """The packages that every ROS has; half a second to load, and needed only where they are not installed."""
    return get_typestore(Stores.ROS2_JAZZY)


def _shipped(name: str) -> Iterator[Path]:
    """Where the source tree has a type, or the installed package's data."""
    package, stem = name.split("/")
    source = Path(__file__).parents[3] / "msg"
    yield (source if package == "roadmend_msgs" else source / "vendor" / package) / "msg" / f"{stem}.msg"
    for parent in (Path(sys.prefix), *Path(__file__).parents):
        yield parent / "share" / "roadmend" / "msg" / package / f"{stem}.msg"


def _candidates(name: str, suffix: str) -> Iterator[Path]:
    package, stem = name.split("/")
    prefixes = [*filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)), sys.prefix]
    for prefix in dict.fromkeys(prefixes):
        yield Path(prefix, "share", package, "msg", stem + suffix)


def _installed_hash(full_name: str) -> str:
    """The hash as the message generator installed it, or an empty string."""
    for path in _candidates(full_name.replace("/msg/", "/"), ".json"):
        if path.is_file():
            hashes = json.loads(path.read_text("utf-8")).get("type_hashes", [])
            return next((str(one["hash_string"]) for one in hashes if one["type_name"] == full_name), "")
    return ""
