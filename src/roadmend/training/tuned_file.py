"""The rivals' best settings on disk: YAML, with what they were found on."""

from pathlib import Path
from typing import Any

import yaml

from roadmend.core.settings import check_settings
from roadmend.core.whole_file import write_text
from roadmend.core.yaml_file import read_fields
from roadmend.measures.fitting import TunedMethods
from roadmend.training.tuning_grid import rivals_of
from roadmend.world.corpus import Case


def first_cases(cases: list[Case], number: int | None) -> list[Case]:
    """The first ``number`` of each family and kind, in order; all of them for None."""
    counts: dict[tuple[str, bool], int] = {}
    chosen = []
    for case in cases:
        key = case.family, case.is_violation
        counts[key] = counts.get(key, 0) + 1
        if number is None or counts[key] <= number:
            chosen.append(case)
    return chosen


def read_tuned(path: Path, header: dict[str, Any]) -> dict[str, Any]:
    """Rivals in a file of the same kind; nothing where the file is of another corpus or number of cases.

    Raises:
        InputError: the file is something else.
    """
    if not path.exists():
        return {}
    mend = "remove it, or choose another --out"
    content = read_fields(path, mend)
    check_settings(content, TunedMethods, str(path), mend)
    same = all(content.get(name) == value for name, value in header.items())
    return dict(content["methods"]) if same else {}


def write_tuned(path: Path, header: dict[str, Any], found: dict[str, Any]) -> None:
    """Write the rivals' settings, in the order of the grid.

    Raises:
        InputError: the place cannot be written.
    """
    ordered = {name: found[name] for name in (rival.name for rival in rivals_of("")) if name in found}
    text = (
        "# Each rival's best setting on the validation split, and the whole grid; see 'roadmend train rivals --help'.\n"
    )
    text += yaml.safe_dump({**header, "methods": ordered}, sort_keys=False, width=120, default_flow_style=None)
    write_text(path, text)
