"""YAML files, read strictly: of a sensible size, every key once, and errors in one line that name the line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from roadmend.core.bounded_file import UTF8, read_text
from roadmend.core.bounds import SETTINGS, Bounds
from roadmend.core.errors import InputError

# PyYAML's own parser in C where it was built with it: the same language, many times faster.
_SafeLoader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# Whatever the constructors of YAML's own types stumble over: "!!int ''", "!!timestamp x", "!!bool 1".
_BROKEN = (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError, OverflowError, RecursionError)
_NUMBERS = frozenset({"tag:yaml.org,2002:int", "tag:yaml.org,2002:float"})


def read_fields(path: Path, mend: str, bounds: Bounds = SETTINGS) -> dict[str, Any]:
    """Names and values from a YAML file; none from an empty one.

    Raises:
        InputError: the file cannot be read, is no YAML, or holds something else.
    """
    content = read_yaml(path, mend, bounds)
    if content is None:
        return {}
    if not isinstance(content, dict) or not all(isinstance(name, str) for name in content):
        raise InputError(str(path), "holds no fields", mend)
    return content


def read_yaml(path: Path, mend: str = UTF8, bounds: Bounds = SETTINGS) -> Any:
    """The plain data of a YAML file.

    Raises:
        InputError: the file is missing, no regular file, too large, no text or no YAML, goes beyond the bounds, or a
            mapping in it has a key twice.
    """
    return parse_yaml(read_text(path, bounds, mend), str(path), bounds)


def parse_yaml(text: str | bytes, where: str, bounds: Bounds = SETTINGS) -> Any:
    """The plain data of a YAML text.

    Raises:
        InputError: it is no YAML, goes beyond the bounds, or a mapping in it has a key twice.
    """
    with _refused_in_a_line(where):
        _check_structure(text, where, bounds)
        return yaml.load(text, Loader=_Loader)  # noqa: S506 - a SafeLoader


def compose_yaml(text: str, where: str, bounds: Bounds = SETTINGS) -> yaml.Node | None:
    """The nodes of a YAML text, which say where in it something stands; None of an empty one.

    Raises:
        InputError: it is no YAML, or goes beyond the bounds.
    """
    with _refused_in_a_line(where):
        _check_structure(text, where, bounds)
        node: yaml.Node | None = yaml.compose(text, Loader=_SafeLoader)
        return node


@contextmanager
def _refused_in_a_line(where: str) -> Iterator[None]:
    try:
        yield
    except yaml.MarkedYAMLError as error:
        line = f" at line {error.problem_mark.line + 1}" if error.problem_mark is not None else ""
        raise InputError(where, f"broken YAML{line}: {error.problem or 'cannot be parsed'}", "mend the line") from None
    except _BROKEN as error:
        problem = " ".join(str(error).split())
        raise InputError(where, f"broken YAML: {problem}", "mend the file") from None


def _check_structure(text: str | bytes, where: str, bounds: Bounds) -> None:
    """Look at what a text asks for before anything is built, which would recurse and follow every alias.

    Raises:
        InputError: it goes beyond the bounds.
        yaml.YAMLError: it is no YAML.
    """
    sizes: dict[str, int] = {}  # by anchor, of what it stands for, with what that refers to in its turn
    open_nodes: list[tuple[str | None, int]] = []  # anchor, and how many values there were before
    count = 0
    for event in yaml.parse(text, Loader=_SafeLoader):
        anchor = getattr(event, "anchor", None)
        if isinstance(event, yaml.AliasEvent):
            if any(anchor == name for name, _ in open_nodes):
                raise _refusal(where, event, f"{anchor} refers to itself", "write it out")
            count += sizes.get(str(anchor), 1)
        elif isinstance(event, yaml.CollectionStartEvent):
            open_nodes.append((anchor, count))
            count += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            name, before = open_nodes.pop()
            if name is not None:
                sizes[name] = count - before
        elif isinstance(event, yaml.ScalarEvent):
            count += 1
            if anchor is not None:
                sizes[anchor] = 1
        if len(open_nodes) > bounds.depth:
            raise _refusal(where, event, f"nested deeper than {bounds.depth} levels", "flatten it")
        if count > bounds.values:
            what = f"more than {bounds.values} values, those counted that aliases repeat"
            raise _refusal(where, event, what, "split the file")


def _refusal(where: str, event: yaml.Event, what: str, mend: str) -> InputError:
    line = f" at line {event.start_mark.line + 1}" if event.start_mark is not None else ""
    return InputError(where, f"broken YAML{line}: {what}", mend)


class _Loader(_SafeLoader):  # type: ignore[misc]
    """Refuses keys that are there twice, of which YAML's own keeps the last in silence, and numbers without end."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:  # noqa: FBT001, FBT002
        names = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.tag != "tag:yaml.org,2002:merge":
                if (key.tag, key.value) in names:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"field {key.value} is there twice", key.start_mark
                    )
                names.add((key.tag, key.value))
        written = len(node.value) if len(names) == len(node.value) else 0
        found: dict[Any, Any] = super().construct_mapping(node, deep=deep)
        if len(found) < written:
            raise yaml.constructor.ConstructorError(None, None, "two fields have one name", node.start_mark)
        return found

    def construct_scalar(self, node: yaml.ScalarNode) -> Any:
        if node.tag in _NUMBERS and len(node.value) > SETTINGS.digits:
            what = f"a number of {len(node.value)} digits, at most {SETTINGS.digits} are read"
            raise yaml.constructor.ConstructorError(None, None, what, node.start_mark)
        return super().construct_scalar(node)
