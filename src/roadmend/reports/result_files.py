"""Benchmark results on disk: JSON for programs, Markdown for people, with what made them."""

import json
import os
import platform
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roadmend import __version__
from roadmend.core.markdown import table_text
from roadmend.core.resources import clone_folder
from roadmend.core.whole_file import write_texts

_UNKNOWN = "unknown"
_SOURCES = ("src", "tests/benchmarks")  # in which a file counts before it is in a commit
_RESULTS = [f":(exclude,glob)tests/benchmarks/*.{ending}" for ending in ("md", "json", "html", "png", "svg", "pdf")]


def provenance(command: str) -> dict[str, Any]:
    """The command, the commit and the machine behind a figure.

    The commit is that of roadmend, wherever the user stands: ``dirty`` says whether its files differ from it, the harness
    of the benchmarks and sources that are not in it yet among them, but not what benchmarks write. Of an installed package
    there is its version instead.
    """
    root = clone_folder()
    commit = _git(root, "rev-parse", "HEAD") if root else f"roadmend {__version__}"
    return {
        "command": command,
        "commit": commit,
        "dirty": bool(root and commit != _UNKNOWN and _is_changed(root)),
        "machine": {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "system": f"{platform.system()} {platform.release()}",
            "python": platform.python_version(),
        },
    }


def write_report(
    folder: Path,
    name: str,
    title: str,
    content: Mapping[str, Any],
    rows: Sequence[Sequence[str]],
    more: Sequence[Sequence[str]] = (),
) -> None:
    """Write NAME.json and NAME.md.

    Args:
        folder: to write into.
        name: of the files, without an ending.
        title: of the page.
        content: of the JSON, with its ``provenance``.
        rows: of the table, the heading first.
        more: of a second table; none where it is empty.

    Raises:
        InputError: the folder cannot be written.
    """
    tables = "\n\n".join(table_text(table) for table in (rows, more) if table)
    text = f"# {title}\n\n{tables}\n\n{origin(content['provenance'])}\n"
    write_texts(folder, {f"{name}.json": json.dumps(content, indent=2) + "\n", f"{name}.md": text})


def origin(made: Mapping[str, Any]) -> str:
    """One line about what made a file."""
    machine = made["machine"]
    changed = " (changed)" if made["dirty"] else ""
    line = (
        f"Made by `{made['command']}` {_at(made['commit'])}{changed} on {machine['processor']}, "
        f"{machine['cores']} cores, Python {machine['python']}."
    )
    for entry in made.get("kept", ()):
        line += f" Kept from `{entry['command']}` {_at(entry['commit'])}: {', '.join(entry['methods'])}."
    return line


def _at(commit: str) -> str:
    return f"with {commit}" if commit.startswith("roadmend ") else f"at commit {commit[:12]}"


def _is_changed(root: Path) -> bool:
    """Whether anything that could move a figure differs from the commit."""
    tracked = _git(root, "status", "--porcelain", "--untracked-files=no", "--", ".", ":!README.md", *_RESULTS)
    return bool(tracked or _git(root, "status", "--porcelain", "--untracked-files=all", "--", *_SOURCES, *_RESULTS))


def _git(root: Path, *arguments: str) -> str:
    """What git says; without git, or in a clone without its history, that it is unknown."""
    try:
        words = ["git", "-C", str(root), *arguments]
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return _UNKNOWN


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
