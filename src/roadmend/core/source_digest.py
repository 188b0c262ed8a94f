"""A digest of the code that decides how an episode runs: results of one version must not pass for another's."""

import ast
import hashlib
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from sysconfig import get_paths
from threading import Lock
from typing import NamedTuple

from roadmend.core.errors import InputError

_PACKAGE = "roadmend"
_INSTALLED = {Path(path) for name, path in get_paths().items() if name not in {"data", "scripts"}}
_LOCK = Lock()  # the parser of Python 3.11 is not made for several threads
_TABLES = {  # know everybody; what they decide themselves, whoever is asked for
    "roadmend.policies.registry": (),
    "roadmend.repair.registry": ("roadmend.repair.guard", "roadmend.repair.none"),
}
_Content = tuple[str, tuple[str, ...]]  # what a module says, shortened, and which modules it imports


class _Known(NamedTuple):
    loaded: object  # what every import and reload makes anew; None of a module that is not imported
    state: tuple[Path, int, int]  # path, time of change and size of the file
    content: _Content


_THEIRS: dict[str, _Known] = {}


def source_digest(modules: Iterable[str]) -> str:
    """SHA-256 of modules and of all that they import from their packages and ours; deaf to comments, docstrings and layout.

    Imports count wherever they stand, those within functions too, and of a user's code also those of files that nobody
    has installed, such as a module beside it. Our own modules are read once a process, a user's when it was reloaded
    too. The tables of policies and methods are not followed,
    so that another method's code does not count: name the modules of the policy and of the method themselves. Where
    package data is read, all files beneath the module count; of other libraries, their versions.

    Args:
        modules: full names, of roadmend or of another package.

    Raises:
        InputError: a module has no source file, or was edited and not reloaded since an earlier digest.
    """
    asked = tuple(sorted(set(modules)))
    with _LOCK:
        return _digest_of_ours(asked) if {*map(_root, asked)} == {_PACKAGE} else _digest(asked)


@cache
def _digest_of_ours(modules: tuple[str, ...]) -> str:
    return _digest(modules)


def _digest(modules: tuple[str, ...]) -> str:
    own = {_PACKAGE, *map(_root, modules)}
    open_ends, closed, roots = [*modules], set[str](), set[str]()
    while open_ends:
        name = open_ends.pop()
        if name in closed:
            continue
        if name in _TABLES:
            open_ends += _TABLES[name]
            continue
        closed.add(name)
        imported = _read(name)[1]
        is_theirs = _root(name) != _PACKAGE
        open_ends += [
            each
            for each in imported
            if (_root(each) in own and _path(each) is not None) or (is_theirs and _is_loose(each))
        ]
        roots |= set(map(_root, imported))
    digest = hashlib.sha256()
    for name in sorted(closed):
        digest.update(f"\0{name}\0{_read(name)[0]}".encode())
    for library in sorted(roots - own - sys.stdlib_module_names):
        digest.update(f"\0{library}\0{_version(library)}".encode())
    return digest.hexdigest()


def _read(name: str) -> _Content:
    if _root(name) == _PACKAGE:
        return _read_ours(name)
    path = _path(name)
    if path is None:
        raise _no_source(name)
    said, imported = _read_theirs(name, path)
    return _with_data(path, said, imported)


@cache
def _read_ours(name: str) -> _Content:
    path = _path(name)
    if path is None:
        raise _no_source(name)
    return _with_data(path, *_content(name, path))


def _read_theirs(name: str, path: Path) -> _Content:
    """As the module was when it was imported, as far as can be told: the file of one that runs may be edited meanwhile.

    Raises:
        InputError: what is in the file now is not what was imported.
    """
    module = sys.modules.get(name)
    loaded = getattr(module, "__spec__", None) or module  # an importlib.reload makes the first one anew
    known = _THEIRS.get(name)
    try:
        about = path.stat()
        state = path, about.st_mtime_ns, about.st_size
        if known is not None and known.loaded is loaded and known.state == state:
            return known.content
        content = _content(name, path)
    except OSError:
        raise _no_source(name) from None
    except (SyntaxError, ValueError):  # in the midst of an edit
        content = None
    if content is None or (known is not None and loaded is known.loaded is not None and content != known.content):
        what = "was edited after it was imported, so that nothing it does can be kept"
        raise InputError(name, what, "reload it with importlib.reload, or start Python anew")
    _THEIRS[name] = _Known(loaded, state, content)
    return content


def _content(name: str, path: Path) -> _Content:
    """The packages around a module are run before it."""
    tree = ast.parse(path.read_bytes())
    imported = set(_imports(tree, name if path.name == "__init__.py" else name.rpartition(".")[0]))
    around = {name.rsplit(".", depth)[0] for depth in range(1, name.count(".") + 1)}
    return hashlib.sha256(_meaning(tree).encode()).hexdigest(), tuple(sorted(imported | around))


def _with_data(path: Path, said: str, imported: tuple[str, ...]) -> _Content:
    """With what lies beneath a module that reads package data."""
    if "importlib.resources" not in imported:
        return said, imported
    digest = hashlib.sha256(said.encode())
    for file in sorted(each for each in path.parent.rglob("*") if each.is_file() and _is_data(each)):
        about = file.stat()
        content = _data_digest(file, about.st_mtime_ns, about.st_size)
        digest.update(f"\0{file.relative_to(path.parent)}\0{content}".encode())
    return digest.hexdigest(), imported


@cache
def _data_digest(path: Path, _changed_ns: int, _size: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _no_source(name: str) -> InputError:
    return InputError(name, "has no source, so that nothing it does can be kept", "put it into a file of its own")


def _imports(tree: ast.AST, package: str) -> Iterator[str]:
    """Names of what is imported; what is taken from a module may be a module itself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            above = package.rsplit(".", node.level - 1)[0] if node.level else ""
            module = ".".join(filter(None, (above, node.module)))
            yield from (module, *(f"{module}.{alias.name}" for alias in node.names))
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def _is_loose(name: str) -> bool:
    """Whether a module lies where nothing is installed, so that no version says what is in it."""
    path = _path(name)
    return path is not None and not any(path.is_relative_to(folder) for folder in _INSTALLED)


def _is_data(path: Path) -> bool:
    return path.suffix not in {".py", ".pyc"} and "__pycache__" not in path.parts


def _path(name: str) -> Path | None:
    """The source of a module; None where there is none of this name."""
    return _path_of_ours(name) if _root(name) == _PACKAGE else _find(name)


@cache
def _path_of_ours(name: str) -> Path | None:
    return _find(name)


def _find(name: str) -> Path | None:
    file = getattr(sys.modules.get(name), "__file__", None)
    if file is not None:
        return Path(file) if file.endswith(".py") else None
    first, *others = name.split(".")
    try:
        spec = None if first == "__main__" else find_spec(first)
    except ValueError:  # a module that somebody has put together by hand
        spec = None
    if spec is None:
        return None
    if not others:
        paths = [Path(spec.origin)] if spec.has_location and spec.origin else []
    else:  # beneath each of the folders of a package, of which one without an __init__.py may have several
        places = [Path(folder).joinpath(*others) for folder in spec.submodule_search_locations or ()]
        paths = [path for place in places for path in (place.with_suffix(".py"), place / "__init__.py")]
    return next((path for path in paths if path.suffix == ".py" and path.is_file()), None)


def _root(name: str) -> str:
    return name.partition(".")[0]


@cache
def _version(library: str) -> str:
    """As it was installed; empty for one that is not, or under another name than it is imported by."""
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return ""


def meaning(source: str) -> str:
    """What is left of a module's source without comments, docstrings and layout."""
    return _meaning(ast.parse(source))


def _meaning(tree: ast.AST) -> str:
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        first = node.body[0] if node.body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            node.body = node.body[1:]
    return ast.dump(tree)
