"""What other commands have measured of the same methods, in the one file that programs read: adreft.json."""

from pathlib import Path
from typing import Any

from harness.benchmark_files import read_json, write_benchmark

_STEM = "adreft"
_PARTS = {
    "adreft-ordinary.json": ("ordinary", "curve", "at_time_lost"),
    "adreft-controls.json": ("controls", "bound"),
}


def beside(folder: Path) -> dict[str, Any]:
    """What is in the folder of the others; None for what is not.

    Raises:
        InputError: a file is damaged.
    """
    found: dict[str, Any] = {}
    for name, keys in _PARTS.items():
        path = folder / name
        content = read_json(path) if path.is_file() else {}
        found |= {key: content.get(key) for key in keys}
    path = folder / "adreft-robustness.json"
    return found | {"robustness": read_json(path) if path.is_file() else None}


def renew(folder: Path) -> None:
    """Take what another command has just written into adreft.json and its tables, where there are any.

    Raises:
        InputError: a file is damaged, or the folder cannot be written.
    """
    if (folder / f"{_STEM}.json").is_file():
        content, cases = (read_json(folder / f"{_STEM}{part}.json") for part in ("", "-cases"))
        write_benchmark(folder, _STEM, content | beside(folder), cases)
