"""src/doc/architecture.md says nothing that is not there: files, registries, names, layers."""

import ast
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest

from roadmend.cli.main import cli

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "roadmend"
PAGE = (ROOT / "src" / "doc" / "architecture.md").read_text(encoding="utf-8")
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]

PLACEHOLDER = re.compile(r"\b(NAME|ROOM|test_MODULE)\b")
PROSE = re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL)
TERMS = sorted(set(re.findall(r"`([^`]+)`", PROSE)))
FILES = sorted(set(re.findall(r"[\w/.]+\.(?:py|toml|yaml)\b", PAGE)))
DEFINED = sorted(set(re.findall(r"`(_?[A-Z]\w+|console_scripts)` in `([\w/.]+\.py)`", PROSE)))
LAYERS = [re.findall(r"[^|]+", line) for line in PAGE.splitlines() if re.match(r"\| \d \|", line)]
GIVEN = {"--json", "--help", "name", "x:=1"}  # of no code of ours: options that commands have, attributes


def found(path):
    """Whether a file or folder is there, or with a placeholder in it the folder where it would be."""
    while PLACEHOLDER.search(path):
        path = path.rpartition("/")[0]
    return any((folder / path).exists() for folder in (ROOT, ROOT / "src", PACKAGE))


@cache
def code():
    return "\n".join(path.read_text(encoding="utf-8") for path in [*PACKAGE.rglob("*.py"), PACKAGE.parent / "setup.py"])


def names_of(path):
    """What a file defines at its top."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = {each.name for each in tree.body if isinstance(each, ast.ClassDef | ast.FunctionDef)}
    for each in tree.body:
        if isinstance(each, ast.Assign):
            names |= {target.id for target in each.targets if isinstance(target, ast.Name)}
        elif isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name):
            names.add(each.target.id)
    return names


def is_there(term):
    """Whether what stands in backticks is there: a command line, a file, a signature, a dotted name or a name."""
    if term in GIVEN or term in cli.commands or term in cli.table:
        return True
    if re.search(r" -m | --|^\./", term):  # a command line
        modules = re.findall(r"-m roadmend\.([\w.]+)", term)
        return all(found(module.replace(".", "/").replace("/NAME", "")) for module in modules)
    if re.fullmatch(r"\.venv/bin/python \S+", term):
        return found(term.split()[1])
    if "/" in term or term.endswith((".py", ".toml", ".yaml")):
        return found(term)
    if term.startswith("@"):
        return term in code()
    if signature := re.fullmatch(r"(\w+)\((.*)\)(?: -> (\w+))?", term):
        name, arguments, result = signature.groups()
        wanted = "".join(rf", {argument}: [^,)]+" for argument in filter(None, arguments.split(", ")))
        return re.search(rf"def {name}\(self{wanted}\) -> {result or '.+'}:", code()) is not None
    *parts, last = term.split(".")
    if parts and (PACKAGE / "/".join(parts)).with_suffix(".py").exists():
        return last in names_of((PACKAGE / "/".join(parts)).with_suffix(".py"))
    if PLACEHOLDER.search(last.removesuffix("_node")) or found("roadmend/" + term):
        return True
    return re.search(rf"\b{re.escape(term)}\b", code()) is not None


@pytest.mark.parametrize("term", TERMS)
def test_what_stands_in_backticks_is_there(term):
    assert is_there(term)


@pytest.mark.parametrize("file", FILES)
def test_every_file_is_there(file):
    assert found(file)


@pytest.mark.parametrize(("name", "file"), DEFINED)
def test_every_registry_is_in_its_file(name, file):
    path = next(folder / file for folder in (PACKAGE, ROOT) if (folder / file).exists())
    assert name in names_of(path) or f'"{name}": [' in path.read_text(encoding="utf-8")


def test_the_page_names_every_registry():
    assert {name for name, _ in DEFINED} >= {
        "POLICIES",
        "METHODS",
        "TECHNIQUES",
        "FAMILIES",
        "NODES",
        "console_scripts",
    }
    assert "MEASURES" in names_of(PACKAGE / "measures" / "registry.py")


def test_the_layers_are_those_of_the_contract():
    (contract,) = [each for each in CONTRACTS if each["type"] == "layers"]
    assert [set(re.findall(r"`(\w+)`", row[1])) for row in LAYERS] == [
        set(layer.split(" | ")) for layer in contract["layers"]
    ]
    assert [int(row[0]) for row in LAYERS] == [*range(len(LAYERS) - 1, -1, -1)]


@pytest.mark.parametrize("row", LAYERS, ids=lambda row: row[0].strip())
def test_a_library_of_a_room_is_kept_there_by_a_contract(row):
    rooms = re.findall(r"`(\w+)`", row[1])
    libraries = re.findall(r"\w+", re.sub(r"`\w+`|\.\w+|\band\b|\bmessages\b", "", row[3] if len(row) > 3 else ""))
    for library in libraries:
        contracts = [each for each in CONTRACTS if library in each.get("forbidden_modules", ())]
        allowed = {edge.split(" ")[0] for each in contracts for edge in each.get("ignore_imports", ())}
        assert any(source.startswith(f"roadmend.{room}.") for source in allowed for room in rooms), library


def test_the_page_fits_two_screens():
    assert len(PAGE.splitlines()) <= 62
