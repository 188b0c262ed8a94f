"""A selection on disk: what ``roadmend sera recommend --json`` prints, and the scenarios in it."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from roadmend.core.errors import InputError
from roadmend.sera.bank import Bank
from roadmend.world.scenario import Scenario

Stage = Literal["initial", "refined", "random"]
_MEND = "give what 'roadmend sera recommend --json' printed"


@dataclass(frozen=True, slots=True)
class Selection:
    """Scenarios of a bank to learn from."""

    digests: tuple[str, ...]  # of the scenarios, each once
    digest: str  # SHA-256 of the file, hexadecimal


def read_selection(path: Path, stage: Stage) -> Selection:
    """Read one stage of a selection.

    Raises:
        InputError: the file is missing or no selection, or has nothing at this stage.
    """
    try:
        data = path.read_bytes()
        content: Any = json.loads(data)
        digests = tuple(dict.fromkeys(str(each["digest"]) for each in content[stage]))
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", _MEND) from None
    except (ValueError, KeyError, TypeError):
        raise InputError(str(path), f"is no selection with a {stage!r} stage", _MEND) from None
    if not digests:
        raise InputError(
            str(path), f"selects nothing at the {stage!r} stage", "select from a bank that holds something"
        )
    return Selection(digests, hashlib.sha256(data).hexdigest())


def scenarios_of(selection: Selection, bank: Bank) -> list[Scenario]:
    """The scenarios of a selection, out of the bank that it was made from.

    Raises:
        InputError: the bank does not hold one of them, or only its description.
    """
    found = []
    for digest in selection.digests:
        entry = bank.find(digest)
        if entry is None:
            raise InputError(str(bank.path), f"holds no scenario {digest[:12]}", "give the bank that was selected from")
        if entry.scenario is None:
            raise InputError(str(bank.path), f"only describes {entry.name}", "select from a bank of whole scenarios")
        found.append(entry.scenario)
    return found
