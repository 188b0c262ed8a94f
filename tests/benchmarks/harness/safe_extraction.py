"""What of crash reports is read right: by half, with and without the sketch, beside a trivial reader, and how surely."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from harness.crash_reading import ReadCrash
from harness.scoring import Oracle, Scores, calibrate, filled, load_oracles, majority, mark, oracles_of_records, score

OTHER = "other"  # reports of neither half

Read = Callable[[Path, bool], list[ReadCrash]]  # reports of a folder, with the sketch or without


def gather_oracles(reports: Path, records: Path | None) -> dict[str, Oracle]:
    """All oracles that there are: of the reports themselves, else of the records.

    Raises:
        InputError: one is damaged.
    """
    found = oracles_of_records(records) if records is not None else {}
    return found | load_oracles(reports)


def groups_of(names: Iterable[str], halves: Mapping[str, frozenset[str]]) -> dict[str, set[str]]:
    """The names by half; those in neither are a group of their own."""
    known = frozenset().union(*halves.values())
    groups = {half: {*names} & own for half, own in halves.items()} | {OTHER: {*names} - known}
    return {group: own for group, own in groups.items() if own}


def measure_extraction(
    text: Sequence[ReadCrash],
    sketch: Sequence[ReadCrash],
    oracles: Mapping[str, Oracle],
    halves: Mapping[str, frozenset[str]],
) -> dict[str, Any]:
    """The scores by half; of the text alone where nothing else is said.

    Args:
        text: the reports read without their sketches.
        sketch: the same read with them.
        oracles: what is right, by case.
        halves: names of the reports in each.
    """
    content: dict[str, Any] = {}
    groups = groups_of([each.name for each in text], halves)
    fitted = [oracles[name] for name in sorted(groups.get("seen", ())) if name in oracles]
    trivial = majority(fitted) if fitted else None
    for group, names in groups.items():
        own = {name: oracles[name] for name in names if name in oracles}
        alone = _score(text, own, text_only=True)
        if alone is None:
            continue
        content[group] = {
            **asdict(alone),
            "with_sketch": _plain(_score(sketch, own, text_only=False)),
            "calibration": {
                "text_only": [asdict(each) for each in calibrate(_marked(text, own, text_only=True))],
                "with_sketch": [asdict(each) for each in calibrate(_marked(sketch, own, text_only=False))],
            },
        }
        if trivial is not None:
            content[group]["majority"] = _plain(score(dict.fromkeys(own, trivial), own, text_only=True))
    return content


def measure_registers(texts: Sequence[ReadCrash], oracles: Mapping[str, Oracle]) -> dict[str, Any] | None:
    """The scores on texts in other words than NHTSA's; None where none has an oracle."""
    found = _score(texts, oracles, text_only=True)
    if found is None:
        return None
    marked = calibrate(_marked(texts, oracles, text_only=True))
    invented = [
        is_given for each in texts if each.name in oracles for is_given in filled(each.data, oracles[each.name])
    ]
    left_open = {"fields": len(invented), "filled": sum(invented)}
    return {**asdict(found), "calibration": [asdict(each) for each in marked], "left_open": left_open}


def _score(read: Sequence[ReadCrash], oracles: Mapping[str, Oracle], *, text_only: bool) -> Scores | None:
    return score({each.name: each.data for each in read}, oracles, text_only=text_only)


def _marked(read: Sequence[ReadCrash], oracles: Mapping[str, Oracle], *, text_only: bool) -> list[tuple[float, bool]]:
    """The confidence of every field that was read and can be decided, and whether it is right."""
    found = []
    for each in read:
        if each.name in oracles and each.data is not None:
            marks = mark(each.data, oracles[each.name], text_only=text_only)
            found += [(each.confidence[path], right) for path, right in marks.items() if path in each.confidence]
    return found


def _plain(found: Scores | None) -> dict[str, Any] | None:
    return None if found is None else asdict(found)
