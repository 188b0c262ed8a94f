"""Repair of driving policies while they drive.

The names of ``roadmend.api.names`` can be taken from here: ``from roadmend import run``. Each is imported when it is
asked for, so that ``import roadmend`` costs nothing, and a policy that takes ``Command`` from here loads no simulator.
"""

from importlib import import_module

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    # Not by an import statement: the rooms below, which all stand on this package, would be importing those above.
    homes: dict[str, str] = import_module("roadmend.api.names").HOMES
    if name not in homes:
        raise AttributeError(f"module 'roadmend' has no attribute {name!r}")
    return getattr(import_module(homes[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *import_module("roadmend.api.names").HOMES])
