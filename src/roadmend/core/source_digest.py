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

from roadmend.core.errors import InputError

_PACKAGE = "roadmend"
_INSTALLED = {Path(path) for name, path in get_paths().items() if name not in {"data", "scripts"}}
_LOCK = Lock()  # the parser of Python 3.11 is not made for several threads
_TABLES = {  # know everybody; what they decide themselves, whoever is asked for
    "roadmend.policies.registry": (),
    "roadmend.repair.registry": ("roadmend.repair.guard", "roadmend.repair.none"),
}


def source_digest(modules: Iterable[str]) -> str:
    """SHA-256 of modules and of all that they import from their packages and ours; deaf to comments, docstrings and layout.

    Imports count wherever they stand, those within functions too, and of a user's code also those of files that nobody
    has installed, such as a module beside it. The tables of policies and methods are not followed,
    so that another method's code does not count: name the modules of the policy and of the method themselves. Where
    package data is read, all files beneath the module count; of other libraries, their versions.

    Args:
        modules: full names, of roadmend or of another package.

    Raises:
        InputError: a module has no source file.
    """
    with _LOCK:
        return _digest(tuple(sorted(set(modules))))


@cache
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
        if _root(name) != _PACKAGE:
            own |= {_root(each) for each in imported if _is_loose(_root(each))}
        open_ends += [each for each in imported if _root(each) in own and _path(each) is not None]
        roots |= set(map(_root, imported))
    digest = hashlib.sha256()
    for name in sorted(closed):
        digest.update(f"\0{name}\0{_read(name)[0]}".encode())
    for library in sorted(roots - own - sys.stdlib_module_names):
        digest.update(f"\0{library}\0{_version(library)}".encode())
    return digest.hexdigest()


@cache
def _read(name: str) -> tuple[str, tuple[str, ...]]:
    """What a module says, shortened, and which modules it imports; the packages around it are run before it."""
    path = _path(name)
    if path is None:
        raise InputError(name, "has no source, so that nothing it does can be kept", "put it into a file of its own")
    tree = ast.parse(path.read_bytes())
    imported = set(_imports(tree, name if path.name == "__init__.py" else name.rpartition(".")[0]))
    around = {name.rsplit(".", depth)[0] for depth in range(1, name.count(".") + 1)}
    digest = hashlib.sha256(_meaning(tree).encode())
    if "importlib.resources" in imported:
        for file in sorted(each for each in path.parent.rglob("*") if each.is_file() and _is_data(each)):
            digest.update(f"\0{file.relative_to(path.parent)}\0".encode() + file.read_bytes())
    return digest.hexdigest(), tuple(sorted(imported | around))


def _imports(tree: ast.AST, package: str) -> Iterator[str]:
    """Names of what is imported; what is taken from a module may be a module itself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            above = package.rsplit(".", node.level - 1)[0] if node.level else ""
            module = ".".join(filter(None, (above, node.module)))
            yield from (module, *(f"{module}.{alias.name}" for alias in node.names))
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@cache
def _is_loose(root: str) -> bool:
    """Whether a module lies where nothing is installed, so that no version says what is in it."""
    path = _path(root)
    return path is not None and not any(path.is_relative_to(folder) for folder in _INSTALLED)


def _is_data(path: Path) -> bool:
    return path.suffix not in {".py", ".pyc"} and "__pycache__" not in path.parts


@cache
def _path(name: str) -> Path | None:
    """The source of a module; None where there is none of this name."""
    file = getattr(sys.modules.get(name), "__file__", None)
    if file is not None:
        return Path(file) if file.endswith(".py") else None
    first, *others = name.split(".")
    spec = None if first == "__main__" else find_spec(first)
    if spec is None or spec.origin is None:
        return None
    place = Path(spec.origin).parent.joinpath(*others)
    paths = [place.with_suffix(".py"), place / "__init__.py"] if others else [Path(spec.origin)]
    return next((path for path in paths if path.is_file()), None)


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
