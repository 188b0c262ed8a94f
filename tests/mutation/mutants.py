"""Small wrong changes to a file, by mutmut's operators and by a few of our own.

mutmut itself would leave out what matters most here: it changes only the bodies of undecorated functions, hence no
compiled kernel, no property and no constant. What is no program is left alone: annotations, decorators, imports, texts
and what stands inside the texts for people. Left out too is what any run would notice and what thus would only flatter
the score: a call with an argument too few, and None in place of a number.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import libcst as cst
from libcst.metadata import MetadataWrapper, ParentNodeProvider, PositionProvider
from mutmut.mutation.mutators import mutation_operators, operator_arg_removal, operator_assignment, operator_string

SKIPPED = (cst.Annotation, cst.Decorator, cst.Import, cst.ImportFrom, cst.FormattedString, cst.TypeAlias)
SHARE = 1.05  # by which a constant is moved
SWAPS = {"min": "max", "max": "min", "sin": "cos", "cos": "sin", "isnan": "isfinite", "isfinite": "isnan"}


@dataclass(frozen=True)
class Mutant:
    """One change to a file."""

    function: str  # where, by its name in the file; empty at the top
    line: int
    before: str  # the line as it is
    after: str  # what becomes of it
    source: str  # of the whole file

    @property
    def name(self) -> str:
        """What the change is, whatever its line is called."""
        return f"{self.function}: {self.before} => {self.after}"


def _moved_constant(node: cst.Float) -> Iterator[cst.CSTNode]:
    """A limit that is a twentieth too large."""
    if node.evaluated_value:
        yield node.with_changes(value=repr(node.evaluated_value * SHARE))


def _swapped_function(node: cst.Call) -> Iterator[cst.CSTNode]:
    """The greater for the smaller, a sine for a cosine."""
    name = node.func.attr if isinstance(node.func, cst.Attribute) else node.func
    if isinstance(name, cst.Name) and name.value in SWAPS:
        yield node.with_deep_changes(name, value=SWAPS[name.value])


def _dropped_statement(node: cst.SimpleStatementLine) -> Iterator[cst.CSTNode]:
    """An assignment or a call that is forgotten."""
    first = node.body[0]
    is_call = isinstance(first, cst.Expr) and isinstance(first.value, cst.Call)
    if is_call or isinstance(first, cst.Assign | cst.AugAssign):
        yield node.with_changes(body=[cst.Pass()])


def _negated_condition(node: cst.If) -> Iterator[cst.CSTNode]:
    """The other branch."""
    condition = node.test.with_changes(lpar=[cst.LeftParen()], rpar=[cst.RightParen()])
    yield node.with_changes(test=cst.UnaryOperation(cst.Not(), condition))


def _forgotten_argument(node: cst.Call) -> Iterator[cst.CSTNode]:
    """None for an argument."""
    return (changed for changed in operator_arg_removal(node) if len(changed.args) == len(node.args))


REPLACED = (operator_string, operator_assignment, operator_arg_removal)
OPERATORS = (
    *(pair for pair in mutation_operators if pair[1] not in REPLACED),
    (cst.Call, _forgotten_argument),
    (cst.Float, _moved_constant),
    (cst.Call, _swapped_function),
    (cst.SimpleStatementLine, _dropped_statement),
    (cst.If, _negated_condition),
)


def _put(parent: cst.CSTNode, node: cst.CSTNode, changed: cst.CSTNode) -> cst.CSTNode:
    """A parent with another child."""
    for field in fields(parent):
        value = getattr(parent, field.name)
        if value is node:
            return parent.with_changes(**{field.name: changed})
        if isinstance(value, list | tuple) and any(each is node for each in value):
            return parent.with_changes(**{field.name: [changed if each is node else each for each in value]})
    raise LookupError(f"{type(parent).__name__} does not hold this {type(node).__name__}")


class _Finder(cst.CSTVisitor):
    """Collects the changed files, each with the name of the function in which it was changed."""

    METADATA_DEPENDENCIES = (ParentNodeProvider, PositionProvider)

    def __init__(self, module: cst.Module, functions: frozenset[str], left_out: frozenset[str]) -> None:
        self.found: list[tuple[str, str]] = []
        self._module = module
        self._lines = module.code.splitlines(keepends=True)
        self._functions, self._left_out = functions, left_out
        self._names: list[str] = []

    def on_visit(self, node: cst.CSTNode) -> bool:
        if isinstance(node, SKIPPED):
            return False
        if isinstance(node, cst.FunctionDef | cst.ClassDef):
            if node.name.value in self._left_out:
                return False
            self._names.append(node.name.value)
        if not self._functions or (self._names and self._names[-1] in self._functions):
            for kind, operator in OPERATORS:
                if isinstance(node, kind):
                    self.found += [
                        (".".join(self._names), self._file_with(node, changed)) for changed in operator(node)
                    ]
        return True

    def on_leave(self, original_node: cst.CSTNode) -> None:
        is_named = isinstance(original_node, cst.FunctionDef | cst.ClassDef)
        if is_named and original_node.name.value not in self._left_out:
            self._names.pop()

    def _file_with(self, node: cst.CSTNode, changed: cst.CSTNode) -> str:
        """The file with one node changed: of a statement on its own only its lines are written anew, which is fast."""
        while not isinstance(node, cst.SimpleStatementLine | cst.Module):
            parent = self.get_metadata(ParentNodeProvider, node)
            node, changed = parent, _put(parent, node, changed)
        if isinstance(node, cst.Module):
            return changed.code
        place = self.get_metadata(PositionProvider, node)
        text = self._module.code_for_node(changed.with_changes(leading_lines=[]))
        before, after = self._lines[: place.start.line - 1], self._lines[place.end.line :]
        return "".join((*before, " " * place.start.column, text, *after))


def _changed_lines(before: list[str], after: list[str]) -> tuple[int, str, str]:
    """Index of the first line that differs, and the lines that do."""
    first = next(index for index, (old, new) in enumerate(zip(before, after, strict=False)) if old != new)
    tail = 0
    while tail < min(len(before), len(after)) - first and before[-1 - tail] == after[-1 - tail]:
        tail += 1
    lines = (text[first : len(text) - tail] for text in (before, after))
    old, new = (" ".join(line.partition("  #")[0].strip() for line in part) for part in lines)
    return first, old, new


def find_mutants(path: Path, functions: Iterable[str] = (), left_out: Iterable[str] = ()) -> list[Mutant]:
    """All changes to a file, or to some functions of it, in the order of their places."""
    source = path.read_text(encoding="utf-8")
    wrapper = MetadataWrapper(cst.parse_module(source))
    finder = _Finder(wrapper.module, frozenset(functions), frozenset(left_out))
    wrapper.visit(finder)
    mutants: dict[str, Mutant] = {}
    for function, text in finder.found:
        if text == source or text in mutants:
            continue
        try:
            compile(text, str(path), "exec")
        except SyntaxError:
            continue
        index, before, after = _changed_lines(source.splitlines(), text.splitlines())
        mutants[text] = Mutant(function, index + 1, before, after, text)
    return sorted(mutants.values(), key=lambda mutant: (mutant.line, mutant.after))
