"""YAML files, read strictly: of a sensible size, every key once, and errors in one line that name the line."""

from pathlib import Path
from typing import Any

import yaml

from roadmend.core.errors import InputError

SIZE_MAX = 16_000_000  # [bytes] of a file; whatever people write is far below


def read_fields(path: Path, mend: str) -> dict[str, Any]:
    """Names and values from a YAML file; none from an empty one.

    Raises:
        InputError: the file cannot be read, is no YAML, or holds something else.
    """
    content = read_yaml(path, mend)
    if content is None:
        return {}
    if not isinstance(content, dict) or not all(isinstance(name, str) for name in content):
        raise InputError(str(path), "holds no fields", mend)
    return content


def read_yaml(path: Path, mend: str = "give a readable UTF-8 text file") -> Any:
    """The plain data of a YAML file.

    Raises:
        InputError: the file is missing, too large, no text or no YAML, or a mapping in it has a key twice.
    """
    try:
        size = path.stat().st_size
        if size > SIZE_MAX:
            what = f"is {size / 1e6:.0f} MB large, at most {SIZE_MAX / 1e6:.0f} are read"
            raise InputError(str(path), what, "give another file")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(str(path), "no such file", mend) from None
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", mend) from None
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"cannot be read ({error})", "give a readable UTF-8 text file") from None
    return parse_yaml(text, str(path))


def parse_yaml(text: str | bytes, where: str) -> Any:
    """The plain data of a YAML text.

    Raises:
        InputError: it is no YAML, or a mapping in it has a key twice.
    """
    try:
        return yaml.load(text, Loader=_Loader)  # noqa: S506 - a SafeLoader
    except yaml.MarkedYAMLError as error:
        line = f" at line {error.problem_mark.line + 1}" if error.problem_mark is not None else ""
        raise InputError(where, f"broken YAML{line}: {error.problem or 'cannot be parsed'}", "mend the line") from None
    except (yaml.YAMLError, UnicodeDecodeError, ValueError) as error:
        problem = " ".join(str(error).split())
        raise InputError(where, f"broken YAML: {problem}", "mend the file") from None
    except RecursionError:
        raise InputError(where, "broken YAML: nested too deeply", "mend the file") from None


class _Loader(yaml.SafeLoader):
    """Refuses keys that are there twice, of which YAML's own keeps the last in silence."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:  # noqa: FBT001, FBT002
        names = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.tag != "tag:yaml.org,2002:merge":
                if (key.tag, key.value) in names:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"field {key.value} is there twice", key.start_mark
                    )
                names.add((key.tag, key.value))
        return super().construct_mapping(node, deep=deep)
