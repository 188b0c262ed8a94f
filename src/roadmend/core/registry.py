"""Registries that are open: what roadmend has by name, and what anybody may add without a change here.

A name is looked up among our own, then among the entry points of installed packages; ``package.module:Class`` is
imported; and where a kind of thing comes as a model file, its path will do.
"""

import importlib
import logging
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Generic, TypeVar

from roadmend.core.errors import InputError
from roadmend.core.foreign import trouble_of

Entry = TypeVar("Entry")

OWN = "roadmend"  # the origin of what is built in
_LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Found(Generic[Entry]):
    """What a registry has found."""

    given: str  # as it was asked for: a name, package.module:Class or a file
    label: str  # short, for names of files, scenarios and ROS parameters; two of one class share it
    entry: Entry
    origin: str  # in words: OWN, or which package, source file or model file it comes from
    modules: tuple[str, ...] = ()  # from outside, in which its code lies; what they import counts as well

    @property
    def is_foreign(self) -> bool:
        """Whether its code comes from outside."""
        return bool(self.modules)


@dataclass(frozen=True)
class Registry(Generic[Entry]):
    """One kind of things, ours and others'.

    Attributes:
        noun: what one of them is, such as "policy".
        group: of the entry points of packages that offer more of them.
        own: by name; a name that is here is never anybody else's.
        adapt: makes an entry of what an import came to, given how it was asked for; refuses what is none by InputError.
        of_model: of the path of a model file, the name of ours that it is for and an entry; None for what is no such path.
        models: how such a path looks, for people; empty where there is none.
    """

    noun: str
    group: str
    own: Mapping[str, Entry]
    adapt: Callable[[str, Any], Entry]
    of_model: Callable[[str], tuple[str, Entry] | None] = lambda _given: None
    models: str = ""

    def find(self, given: str) -> Found[Entry]:
        """Whatever ``given`` stands for. Code from outside is imported: ask for what the user named only.

        Raises:
            InputError: there is none, or it cannot be imported or is nothing of this kind.
        """
        if not isinstance(given, str):
            raise InputError(f"{self.noun} {given!r}", "is no name", f"choose one of {', '.join(self.names)}")
        if given in self.own:
            return Found(given, given, self.own[given], OWN)
        of_model = self.of_model(given)
        if of_model is not None:
            return Found(given, *of_model, f"model file {given}")
        if ":" in given:
            module, _, name = given.partition(":")
            return self._adapted(given, name, _imported(f"{self.noun} {given}", module, name), module, "")
        offered = [point for point in _offered(self.group) if point.name == given]
        if len(offered) > 1:
            packages = " and ".join(sorted(map(_package, offered)))
            raise InputError(f"{self.noun} {given}", f"is offered by {packages}", "uninstall one, or name its class")
        if offered:
            point = offered[0]
            thing = _imported(f"{self.noun} {given}", point.module, point.attr)
            return self._adapted(given, given, thing, point.module, f"{_package(point)}, ")
        raise self._unknown(given)

    def find_installed(self, given: str) -> Found[Entry]:
        """As ``find``, for what a file or a message names: it makes nobody run code that they have not installed.

        Raises:
            InputError: it is ``package.module:Class``, or as ``find``.
        """
        if given not in self.own and ":" in given:
            what = "is code from outside, which runs only where the user names it"
            raise InputError(f"{self.noun} {given}", what, f"choose one of {', '.join(self.names)}")
        return self.find(given)

    @property
    def names(self) -> list[str]:
        """Ours, in their order, then those of installed packages."""
        return [*self.own, *sorted({point.name for point in _offered(self.group)} - {*self.own})]

    def __iter__(self) -> Iterator[Found[Entry] | InputError]:
        """All that have a name; an error where an installed package offers what cannot be used."""
        for name in self.names:
            try:
                yield self.find(name)
            except InputError as error:
                yield error

    @property
    def ways(self) -> str:
        """How one may be named, for people."""
        return f"{', '.join(self.names)}, or give package.module:Class{f' or {self.models}' if self.models else ''}"

    def _adapted(self, given: str, label: str, thing: Any, module: str, package: str) -> Found[Entry]:
        entry = self.adapt(given, thing)
        label = re.sub(r"[^A-Za-z0-9_.]", "_", label)  # ROS takes nothing else in the name of a parameter
        if label in self.own:
            raise InputError(f"{self.noun} {given}", f"is called {label!r} as one of ours", "give it another name")
        home = getattr(thing, "__module__", module)  # another than it was named by, where it is imported from there
        source = getattr(sys.modules.get(home), "__file__", None) or home
        modules = tuple(dict.fromkeys([module, *([home] if home in sys.modules else [])]))
        return Found(given, label, entry, f"{package}{source}", modules)

    def _unknown(self, given: str) -> InputError:
        near = get_close_matches(given, self.names, n=1)
        hint = f", did you mean {near[0]}?" if near else ""
        return InputError(self.noun, f"there is no {given!r}{hint}", f"choose one of {self.ways}")


@cache
def _offered(group: str) -> tuple[EntryPoint, ...]:
    """Once a process: to look through everything that is installed takes longer than an episode's set-up."""
    return tuple(entry_points(group=group))


def _package(point: EntryPoint) -> str:
    distribution = point.dist
    return "an unnamed package" if distribution is None else f"{distribution.name} {distribution.version}"


def _imported(where: str, module: str, name: str) -> Any:
    """What a module has under a name; dots lead into a class.

    The folder that the user is in is a place to import from here, as it is for ``python -m``, but the last one: no file
    in it gets in the way of the standard library's or of an installed package's.

    Raises:
        InputError: there is no such module, it fails, or has nothing of that name.
    """
    folder = str(Path.cwd())
    if folder not in sys.path:
        sys.path.append(folder)  # worker processes get their parent's path
        _LOGGER.info("%s is a place to import from now, for %s", folder, where)
    if not module or not name:
        raise InputError(where, "is no package.module:Class", "write both, such as my_policies:Careful")
    try:
        thing = importlib.import_module(module)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - a module may raise anything
        missing = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
        if missing is not None and (module == missing or module.startswith(f"{missing}.")):
            mend = f"run from the folder that it is in (this is {folder}), or install it"
            raise InputError(where, f"there is no module {missing!r}", mend) from None
        raise InputError(where, f"{module} cannot be imported: {trouble_of(error)}", "mend the module") from None
    for part in name.split("."):
        if not hasattr(thing, part):
            near = get_close_matches(part, dir(thing), n=1)
            hint = f", did you mean {near[0]}?" if near else ""
            file = getattr(sys.modules[module], "__file__", None) or module
            raise InputError(where, f"{file} has no {part!r}{hint}", "name a class that is there")
        thing = getattr(thing, part)
    return thing
