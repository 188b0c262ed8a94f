"""Models that come with roadmend, from a source tree or from an installed package."""

import sys
from pathlib import Path

from roadmend.core.errors import InputError

SUFFIX = ".safetensors"


def models_folder() -> Path:
    """The folder config/models of the project; where it is neither in the source tree nor installed, where it would be."""
    candidates = [Path(__file__).parents[3] / "config" / "models"]
    candidates += [
        parent / "share" / "roadmend" / "config" / "models" for parent in (Path(sys.prefix), *Path(__file__).parents)
    ]
    return next((folder for folder in candidates if folder.is_dir()), candidates[0])


def find_model(given: str, prefix: str = "") -> Path:
    """The file of a model that is given by the name of one that ships with roadmend, or as a path.

    Args:
        given: a path ends with ".safetensors"; anything else is a name.
        prefix: what the shipped file's name has before ``given``, such as "adreft-".

    Raises:
        InputError: there is no such file.
    """
    if given.endswith(SUFFIX):
        path = Path(given)
        if not path.is_file():
            raise InputError(given, "no such model file", "give the path of one, or the name of a shipped model")
        return path
    folder = models_folder()
    path = folder / f"{prefix}{given}{SUFFIX}"
    if "/" in given or not path.is_file():
        known = sorted(
            file.name.removeprefix(prefix).removesuffix(SUFFIX) for file in folder.glob(f"{prefix}*{SUFFIX}")
        )
        choice = f"choose one of: {', '.join(known)}" if known else "train one"
        raise InputError(f"model '{given}'", f"roadmend ships no {prefix}{given}{SUFFIX}", f"{choice}, or give a path")
    return path
