"""JSON from outside, read strictly: of a sensible depth and size, every name once, and errors in one line."""

import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

from roadmend.core.bounded_file import read_text
from roadmend.core.bounds import SETTINGS, Bounds
from roadmend.core.errors import InputError

# A text that does not end counts as one, so that no place is looked at twice.
_STRUCTURE = re.compile(r'"(?:[^"\\]|\\.|\\\Z)*+"?|[\[{,]|[\]}]', re.DOTALL)
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")


def read_json(path: Path, bounds: Bounds = SETTINGS, mend: str = "give a JSON file") -> Any:
    """The plain data of a JSON file.

    Raises:
        InputError: the file is missing, cannot be read, is no regular file, or as ``parse_json``.
    """
    return parse_json(read_text(path, bounds, mend), str(path), bounds, mend)


def parse_json(
    text: str | bytes, where: str, bounds: Bounds = SETTINGS, mend: str = "mend the file", *, is_line: bool = False
) -> Any:
    """The plain data of a JSON text. NaN and infinities are taken as Python writes them.

    Args:
        text: the content; bytes are UTF-8.
        where: what to call it in an error.
        bounds: what it may ask for.
        mend: what the user can do about it.
        is_line: whether it is a line of a file, and ``where`` says which.

    Raises:
        InputError: it is no JSON, goes beyond the bounds, or an object in it has a name twice.
    """
    try:
        text = text.decode("utf-8") if isinstance(text, bytes) else text
        _check_structure(text, bounds)
        digits = re.search(rf"[0-9]{{{bounds.digits + 1}}}", text)  # perhaps only within a text
        number = _bounded(bounds) if digits else None
        content = json.loads(text, object_pairs_hook=_unique, parse_int=number)
        if _SURROGATE.search(text):
            json.dumps(content, ensure_ascii=False).encode()  # half a character alone is a ValueError
    except json.JSONDecodeError as error:
        place = where if is_line else f"{where}, line {error.lineno}"
        raise InputError(place, f"broken JSON: {error.msg}", mend) from None
    except UnicodeError:
        raise InputError(where, "broken JSON: it holds what is no character", mend) from None
    except (ValueError, RecursionError) as error:
        raise InputError(where, f"broken JSON: {error}", mend) from None
    return content


def _check_structure(text: str, bounds: Bounds) -> None:
    """Look at depth and number of values before anything is built.

    Raises:
        ValueError: either is too large.
    """
    opening = text.count("[") + text.count("{")
    # What stands in a text counts here: an upper bound, which spares most files the slow way.
    if opening <= bounds.depth and opening + text.count(",") < bounds.values:
        return
    depth, values = 0, 1
    for match in _STRUCTURE.finditer(text):
        sign = match[0]
        if sign in {"[", "{"}:
            depth += 1
            values += 1
        elif sign in {"]", "}"}:
            depth -= 1
        elif sign == ",":
            values += 1
        if depth > bounds.depth:
            raise ValueError(f"it is nested deeper than {bounds.depth} levels")
        if values > bounds.values:
            raise ValueError(f"it holds more than {bounds.values} values")


def _bounded(bounds: Bounds) -> Any:
    def number(text: str) -> int:
        if len(text) > bounds.digits:
            raise ValueError(f"a number has {len(text)} digits, at most {bounds.digits} are read")
        return int(text)

    return number


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        counts = Counter(name for name, _ in pairs)
        twice = next(name for name, count in counts.items() if count > 1)
        raise ValueError(f"field {twice} is there twice")
    return found
