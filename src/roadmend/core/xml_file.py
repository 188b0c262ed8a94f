"""XML from outside, as it is or compressed by gzip: of a sensible size, and without a document type.

Entities, of which small files make large ones or which name other files, can only be declared in a document type, and
no file of SUMO's has one. The standard library's parser tells of it before anything is expanded; a library that
forbids it, such as defusedxml, would parse networks of many megabytes in Python and bounds no depth.
"""

import gzip
import zlib
from pathlib import Path
from typing import Any, BinaryIO
from xml.etree import ElementTree as ET

from roadmend.core.bounded_file import opened_unpacked
from roadmend.core.bounds import NETWORK, Bounds
from roadmend.core.errors import InputError


def read_xml(path: Path, mend: str, bounds: Bounds = NETWORK) -> ET.Element:
    """The root element of an XML file.

    Args:
        path: the file.
        mend: what the user can do where it is none.
        bounds: what it may ask for.

    Raises:
        InputError: the file is missing, cannot be read, is no regular file, is too large, as it lies there or unpacked,
            is no XML, declares a document type, or holds too many elements or too deep ones.
    """
    with opened_unpacked(path, bounds, mend) as file:
        return _parse(file, str(path), mend, bounds)


def _parse(file: BinaryIO, where: str, mend: str, bounds: Bounds) -> ET.Element:
    try:
        parser = ET.XMLParser(target=_Builder(where, bounds))
        return ET.parse(file, parser).getroot()
    except ET.ParseError as error:
        raise InputError(where, f"broken XML ({error})", mend) from None
    except (ValueError, LookupError, EOFError, gzip.BadGzipFile, zlib.error) as error:
        # An encoding that Python does not know or cannot use here; what is compressed is cut or damaged.
        raise InputError(where, f"broken XML ({error})", mend) from None


class _Builder(ET.TreeBuilder):
    """Builds the tree and counts what it builds."""

    def __init__(self, where: str, bounds: Bounds) -> None:
        super().__init__()
        self._where, self._bounds = where, bounds
        self._depth = self._count = 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        """What the parser calls at a document type."""
        del name, pubid, system
        raise InputError(self._where, "declares a document type, which no file of SUMO's has", "take it out")

    def start(self, tag: Any, attrs: dict[Any, Any], /) -> ET.Element:
        """What the parser calls at the beginning of an element."""
        self._depth += 1
        self._count += 1
        if self._depth > self._bounds.depth:
            raise InputError(self._where, f"is nested deeper than {self._bounds.depth} elements", "flatten it")
        if self._count > self._bounds.values:
            what = f"holds more than {self._bounds.values} elements"
            raise InputError(self._where, what, "cut out a part of it, with netconvert say")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> ET.Element:
        """What the parser calls at the end of an element."""
        self._depth -= 1
        return super().end(tag)
