"""The names that can be taken from roadmend: all there, told to type checkers, and cheap."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import roadmend
from roadmend.api.names import HOMES

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", HOMES)
def test_each_is_what_its_home_has(name):
    thing = getattr(roadmend, name)
    assert thing is getattr(import_module(HOMES[name]), name)
    assert thing.__doc__


def test_type_checkers_are_told_the_same():
    tree = ast.parse((ROOT / "src" / "roadmend" / "__init__.pyi").read_text(encoding="utf-8"))
    told = {alias.asname: each.module for each in tree.body if isinstance(each, ast.ImportFrom) for alias in each.names}
    assert told == HOMES


def test_the_page_tells_of_each():
    page = (ROOT / "src" / "doc" / "python.md").read_text(encoding="utf-8")
    assert [name for name in HOMES if f"`{name}" not in page] == []


def test_one_that_is_not_there_is_no_attribute():
    assert not hasattr(roadmend, "drvie")
    with pytest.raises(ImportError, match="cannot import name 'drvie'"):
        exec("from roadmend import drvie")
    assert {"run", "__version__"} <= set(dir(roadmend))


CHILD = """
import sys
before = {*sys.modules}
import roadmend
new = {name.partition(".")[0] for name in {*sys.modules} - before} - sys.stdlib_module_names
assert new == {"roadmend"}, new
from roadmend import Command, Decision, Parameters, Policy, Proposal, Scene, Trajectory
heavy = {"libsumo", "sumolib", "mcap", "rosbags", "rclpy", "matplotlib", "pandas", "torch", "gymnasium"}
assert not heavy & {*sys.modules}, heavy & {*sys.modules}
"""


def test_to_import_it_is_cheap_and_a_policy_loads_no_simulator():
    done = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
