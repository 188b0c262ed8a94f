"""Libraries that a node needs and that only an extra of the package brings."""

import contextlib
import sys
from collections.abc import Iterator

from roadmend.core.extras import extra_missing
from roadmend.nodes.fault import leave_fault


@contextlib.contextmanager
def needed() -> Iterator[None]:
    """Around the imports of what an extra brings: without it the program ends with one line that names the extra.

    A node is a program from its first import on: run by hand, under launch or as a console script, nobody stands above
    who could catch the error.

    Raises:
        SystemExit: with code 2, where a library of an extra is missing.
        ModuleNotFoundError: where another one is; something is broken then.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        refusal = extra_missing(error)
        print(f"roadmend: {refusal}", file=sys.stderr)
        leave_fault(refusal)
        raise SystemExit(2) from None
