"""Told crashes with their keys, from files: what the trained reader learns from and is measured on."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.core.bounded_file import read_lines
from roadmend.core.bounds import TEXT, Bounds
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.safe.reading.reader import read_claims
from roadmend.safe.trained.lessons import Lesson, lesson_of, names_by_words
from roadmend.safe.trained.marked_text import SEATS, named_crash

_MEND = "give a JSON Lines file of told crashes: author, name, text, key"
_LINE = Bounds(size=64_000, values=2_000, depth=16)


@dataclass(frozen=True, slots=True)
class ToldCrash:
    """A text and its key.

    Attributes:
        author: who wrote it, and others of a kind.
        name: among the author's.
        text: the summary.
        key: what it says, the fields of the scenario language as JSON has them.
        called: words by which it names each vehicle; none where nobody has noted them.
    """

    author: str
    name: str
    text: str
    key: Mapping[str, Any]
    called: tuple[tuple[str, ...], ...] = ()


def read_told(path: Path) -> list[ToldCrash]:
    """Read a file of told crashes.

    Raises:
        InputError: it is missing, damaged, or holds none.
    """
    found = [*_read(path)]
    if not found:
        raise InputError(str(path), "holds no told crash", _MEND)
    return found


def _read(path: Path) -> Iterator[ToldCrash]:
    for number, line in enumerate(read_lines(path, TEXT, _MEND), start=1):
        where = f"{path}, line {number}"
        content = parse_json(line, where, _LINE, _MEND, is_line=True)
        try:
            key = dict(content["key"])
            [dict(each) for each in key["vehicles"]]
            called = tuple(tuple(map(str, row)) for row in content.get("called") or ())
            yield ToldCrash(str(content["author"]), str(content["name"]), str(content["text"]), key, called)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise InputError(where, "is no told crash", _MEND) from None


def told_line(crash: ToldCrash) -> str:
    """A told crash as a line of such a file."""
    content = {"author": crash.author, "name": crash.name, "text": crash.text, "key": crash.key}
    return json.dumps(content | ({"called": crash.called} if crash.called else {}), ensure_ascii=False)


def told_lesson(crash: ToldCrash) -> Lesson | None:
    """What can be learned from a told crash: its names as the rules find them, or as they were noted; None if as neither."""
    said = read_claims(crash.text)
    count = len(crash.key["vehicles"])
    if not 0 < count <= SEATS:
        return None
    if said is not None and len(said.kept) == count:
        return lesson_of(named_crash(crash.text, said), crash.key)
    return lesson_of(names_by_words(crash.text, crash.called), crash.key) if len(crash.called) == count else None
