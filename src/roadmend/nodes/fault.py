"""Why a node ended: it leaves that in a file for the launcher, which need not read it out of a log."""

import json
import os
from pathlib import Path

from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.whole_file import write_text

FAULT_FILE = "ROADMEND_FAULT_FILE"  # environment variable with the place of the file; without it none is left


def leave_fault(error: Exception) -> bool:
    """Say why this process is about to end; returns whether there is a launcher that was told."""
    path = os.environ.get(FAULT_FILE)
    if not path:
        return False
    if isinstance(error, InputError):
        content = {"where": error.where, "what": error.what, "mend": error.mend}
    elif isinstance(error, RoadmendError):
        content = {"what": str(error)}
    else:
        content = {"what": " ".join(f"{type(error).__name__}: {error}".split())}
    try:
        write_text(Path(path), json.dumps(content))
    except InputError:  # a full disk; the log has to tell it
        return False
    return True


def read_fault(path: Path) -> RoadmendError | None:
    """What a process has left there, an InputError where it refused what it was given; None if it left nothing."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if "where" in content:
            return InputError(content["where"], content["what"], content["mend"])
        return RoadmendError(content["what"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
