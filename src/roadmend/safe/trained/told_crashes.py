"""Told crashes with their keys, from files: what the trained reader learns from and is measured on."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from roadmend.core.bounded_file import read_lines, read_text
from roadmend.core.bounds import CRASH, TEXT, Bounds
from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.journal import Journal, entry_key
from roadmend.core.json_text import parse_json, read_json
from roadmend.safe.dsl import Action, Compass, DslModel, Position, RoadType, Side, Time, Weather
from roadmend.safe.reading.reader import read_claims
from roadmend.safe.trained.lessons import CrashLesson, lesson_of, names_by_words
from roadmend.safe.trained.marked_text import Name, NamedCrash, named_crash
from roadmend.safe.trained.outputs import SEATS

_MEND = "give a JSON Lines file of told crashes (author, name, text, key), or AUTHOR-NAME.txt beside AUTHOR-NAME.oracle.json"
_NAMES = "roadmend-told-names/1"
_KEY = ".oracle.json"  # of a text in a file of its own
_Kinds = Mapping[str, type[StrEnum] | None]  # words, or None for a number, of each field
_OF_CRASH: _Kinds = {"road_type": RoadType, "stem_direction": Compass, "num_lanes": None}
_OF_VEHICLE: _Kinds = {"initial_position": Position, "action": Action, "model": DslModel, "speed_limit_mph": None}
_OF_ENVIRONMENT: _Kinds = {"time": Time, "weather": Weather}
_OF_COLLISION: _Kinds = {"striking": None, "struck": None, "striking_side": Side, "struck_side": Side}
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
    """Read a file of told crashes, ``.jsonl``, or a text ``.txt`` with its key beside it.

    Raises:
        InputError: it is missing, damaged, or holds none.
    """
    if path.suffix == ".txt":
        return [_read_text(path)]
    found = [*_read(path)]
    if not found:
        raise InputError(str(path), "holds no told crash", _MEND)
    return found


def _read(path: Path) -> Iterator[ToldCrash]:
    for number, line in enumerate(read_lines(path, TEXT, _MEND), start=1):
        where = f"{path}, line {number}"
        content = parse_json(line, where, _LINE, _MEND, is_line=True)
        try:
            called = tuple(tuple(map(str, row)) for row in content.get("called") or ())
            key = _key(content["key"], where)
            yield ToldCrash(str(content["author"]), str(content["name"]), str(content["text"]), key, called)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise InputError(where, "is no told crash", _MEND) from None


def _read_text(path: Path) -> ToldCrash:
    beside = path.with_name(path.stem + _KEY)
    try:
        key = _key(read_json(beside, _LINE, _MEND), str(beside))
    except (KeyError, TypeError, ValueError):
        raise InputError(str(beside), "is no key of a told crash", _MEND) from None
    author, _, name = path.stem.partition("-")
    return ToldCrash(author, name, read_text(path, CRASH, _MEND).strip(), key)


def _key(content: Any, where: str) -> dict[str, Any]:
    key = dict(content)
    key["vehicles"] = [dict(each) for each in key["vehicles"]]
    rows: list[tuple[str, Any, _Kinds]] = [
        (f"vehicles[{at}].", each, _OF_VEHICLE) for at, each in enumerate(key["vehicles"])
    ]
    rows += [("", key, _OF_CRASH), ("env.", dict(key.get("env") or {}), _OF_ENVIRONMENT)]
    rows += [(f"collisions[{at}].", dict(each), _OF_COLLISION) for at, each in enumerate(key.get("collisions") or ())]
    for place, row, kinds in rows:
        for name, kind in kinds.items():
            value = row.get(name)
            if value is not None and not _fits(value, kind):
                wanted = "is no number" if kind is None else f"is none of {', '.join(kind)}"
                raise InputError(where, f"{place}{name}: {json.dumps(value)[:60]} {wanted}", _MEND)
    return key


def _fits(value: Any, kind: type[StrEnum] | None) -> bool:
    if kind is None:
        return isinstance(value, int | float) and not isinstance(value, bool)
    return isinstance(value, str) and (value in {*kind} or value.capitalize() in {*Side} & {*kind})


def told_line(crash: ToldCrash) -> str:
    """A told crash as a line of such a file."""
    content = {"author": crash.author, "name": crash.name, "text": crash.text, "key": crash.key}
    return json.dumps(content | ({"called": crash.called} if crash.called else {}), ensure_ascii=False)


def told_lessons(
    told: Sequence[ToldCrash], work: Path, mapper: Mapper, watch: Callable[[int], None]
) -> list[CrashLesson | None]:
    """What can be learned from each told crash; None where the text names other vehicles than its key.

    Args:
        told: the crashes.
        work: folder in which it is kept where names stand, for reading by the rules takes long.
        mapper: reads the texts.
        watch: hears after each text how many are read.

    Raises:
        InputError: the folder's file is in use, of another format or damaged, or cannot be written.
    """
    keys = [entry_key([__name__], told_line(crash)) for crash in told]
    with Journal(work / "names.jsonl", _NAMES) as journal:
        missing = {key: crash for key, crash in zip(keys, told, strict=True) if journal.get(key) is None}
        for done, (key, named) in enumerate(
            zip(missing, mapper(named_told, [*missing.values()]), strict=True), start=len({*keys}) - len(missing) + 1
        ):
            names = None if named is None else [[each.start, each.end, each.vehicles] for each in named.names]
            journal.add(key, {"names": names})
            watch(done)
        found = [(journal.get(key) or {}).get("names") for key in keys]
    return [_lesson(crash, names) for crash, names in zip(told, found, strict=True)]


def _lesson(crash: ToldCrash, names: Sequence[tuple[int, int, Sequence[int]]] | None) -> CrashLesson | None:
    if names is None:
        return None
    own = tuple(Name(start, end, tuple(vehicles)) for start, end, vehicles in names)
    return lesson_of(NamedCrash(crash.text, own, len(crash.key["vehicles"])), crash.key)


def named_told(crash: ToldCrash) -> NamedCrash | None:
    """A told crash with its names as the rules find them, or as they were noted; None where neither fits its key.

    The rules find more of them, pronouns too, but what they find is taken only where it contradicts no noted name.
    """
    said = read_claims(crash.text)
    count = len(crash.key["vehicles"])
    if not 0 < count <= SEATS:
        return None
    noted = names_by_words(crash.text, crash.called) if len(crash.called) == count else None
    found = named_crash(crash.text, said) if said is not None and len(said.kept) == count else None
    return found if found is not None and (noted is None or _agree(found, noted)) else noted


def _agree(found: NamedCrash, noted: NamedCrash) -> bool:
    """Whether each vehicle is called somewhere as it was noted, and nowhere as another one was."""
    alike = set[int]()
    for own in found.names:
        for other in noted.names:
            if own.start < other.end and other.start < own.end and len(own.vehicles) == 1:
                if own.vehicles != other.vehicles:
                    return False
                alike.update(own.vehicles)
    return alike == {*range(found.count)}
