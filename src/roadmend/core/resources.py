"""Files that come with roadmend, from a source tree or from an installed package."""

import os
import sys
from pathlib import Path

from roadmend.core.errors import RoadmendError


def clone_folder() -> Path | None:
    """The root of the clone of the project that this runs from; None where pip has installed it."""
    root = Path(__file__).parents[3]
    return root if (root / "config").is_dir() and (root / "roadmend").is_file() else None


def config_folder() -> Path:
    """The folder config/ of the project.

    Raises:
        RoadmendError: it is neither in the source tree nor installed.
    """
    candidates = [Path(__file__).parents[3] / "config"]
    candidates += [parent / "share" / "roadmend" / "config" for parent in (Path(sys.prefix), *Path(__file__).parents)]
    for folder in candidates:
        if folder.is_dir():
            return folder
    raise RoadmendError("config/ is missing; run from a clone of the project or install the package with its data")


def cache_folder() -> Path:
    """Where is kept what was built once, such as networks: ROADMEND_CACHE, else the user's cache folder."""
    chosen = os.environ.get("ROADMEND_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "roadmend"
