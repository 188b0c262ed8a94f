"""A digest of the code that decides how an episode runs: results of one version must not pass for another's."""

import ast
import hashlib
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

_TABLES = {"roadmend.policies.registry", "roadmend.repair.registry"}  # know everybody, and decide nothing themselves


def source_digest(modules: Iterable[str]) -> str:
    """SHA-256 of modules and of all that they import from their packages and from roadmend.

    It is deaf to comments, docstrings and layout.

    The tables of policies and methods are not followed, so that another method's code does not count: name the modules
    of the policy and of the method themselves.

    Args:
        modules: full names, of roadmend or of another package.
    """
    return _digest(tuple(sorted(modules)))


@cache
def _digest(modules: tuple[str, ...]) -> str:
    packages = frozenset({"roadmend", *(name.partition(".")[0] for name in modules)})
    open_ends, closed = [*modules], set[str]()
    while open_ends:
        name = open_ends.pop()
        if name not in closed and name not in _TABLES:
            closed.add(name)
            open_ends += _read(name, packages)[1]
    digest = hashlib.sha256()
    for name in sorted(closed):
        digest.update(f"\0{name}\0{_read(name, packages)[0]}".encode())
    return digest.hexdigest()


@cache
def _read(name: str, packages: frozenset[str]) -> tuple[str, tuple[str, ...]]:
    """What a module says, shortened, and which modules of some packages it imports."""
    path = _path(name)
    assert path is not None, name
    source = path.read_text(encoding="utf-8")
    imported = {each for each in _imports(source) if each.partition(".")[0] in packages and _path(each) is not None}
    return hashlib.sha256(meaning(source).encode()).hexdigest(), tuple(sorted(imported))


def _imports(source: str) -> Iterator[str]:
    """The names that may be those of modules."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            yield from (node.module, *(f"{node.module}.{alias.name}" for alias in node.names))
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@cache
def _path(name: str) -> Path | None:
    """The file of a module, None where there is none of this name."""
    first, *others = name.split(".")
    spec = find_spec(first)
    if spec is None or spec.origin is None:
        return None
    package = Path(spec.origin)
    place = package.parent.joinpath(*others)
    for path in (place.with_suffix(".py"), place / "__init__.py") if others else (package,):
        if path.is_file():
            return path
    return None


def meaning(source: str) -> str:
    """What is left of a module's source without comments, docstrings and layout."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        first = node.body[0] if node.body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            node.body = node.body[1:]
    return ast.dump(tree)
