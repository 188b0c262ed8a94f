"""The page of guarantees names tests that there are, and figures that the code has."""

import ast
import re
from pathlib import Path

import pytest

from roadmend.core.command_age import LATE_TICKS, LOCKSTEP_PATIENCE_S, OBEYED_TICKS, PROMPT_S, PROMPT_TICKS
from roadmend.nodes.supervisor import LOCKSTEP_SILENCE_S, REALTIME_SILENCE_S, RESTARTS_MAX, START_S

TESTS = Path(__file__).parent
DOC = TESTS.parent / "src" / "doc"
PAGE = (DOC / "guarantees.md").read_text(encoding="utf-8")
REFERENCES = sorted(set(re.findall(r"`(\w+/\w+\.py)::(\w+)`", PAGE)))


@pytest.mark.parametrize(("file", "name"), REFERENCES)
def test_every_test_that_is_named_is_there(file, name):
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_every_promise_names_a_test():
    promised = PAGE.partition("## Promised")[2].partition("## Not promised")[0]
    rows = [line for line in promised.splitlines() if line.startswith("| ") and not line.startswith("| promise")]
    assert len(rows) > 10
    assert all("::test_" in row for row in rows)


def test_its_figures_are_those_of_the_code():
    graph = (DOC / "graph.md").read_text(encoding="utf-8")
    for words in (
        f"is {LATE_TICKS} ticks old",
        f"{PROMPT_S:g} s or {PROMPT_TICKS:g} ticks",
        f"more than {OBEYED_TICKS} ticks",
    ):
        assert words in graph
    assert f"wall time: {LOCKSTEP_PATIENCE_S:g} s" in graph
    for page in (graph, PAGE):
        assert f"{LOCKSTEP_SILENCE_S:g} s (lockstep) or {REALTIME_SILENCE_S:g} s (real time" in page
        assert f"{START_S:g} s" in page
    assert f"ended {RESTARTS_MAX + 1} times" in PAGE
