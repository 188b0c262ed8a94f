"""What is said where a library is missing that only some commands need."""

import ast
import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from roadmend.core.extras import EXTRAS, extra_missing

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DISTRIBUTIONS = {
    "PIL": "pillow",
    "cv2": "opencv-python-headless",
    "faiss": "faiss-cpu",
    "foxglove": "foxglove-sdk",
    "stable_baselines3": "stable-baselines3",
}  # that are not called like their module


@pytest.mark.parametrize(("module", "extra"), EXTRAS.items())
def test_the_extra_that_is_named_brings_the_module(module, extra):
    brought = [re.split(r"[<>=]", need)[0].lower() for need in PROJECT["optional-dependencies"][extra]]
    assert DISTRIBUTIONS.get(module, module) in brought


def imported_modules():
    """Top-level names of what the package imports anywhere, but for itself and the standard library."""
    for path in (ROOT / "src" / "roadmend").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            yield from {name.partition(".")[0] for name in names} - sys.stdlib_module_names - {"roadmend"}


def always_installed():
    """Distributions that the package needs without any extra, and what those need, by their normalised names."""
    found, open_ends = set(), [Requirement(each) for each in PROJECT["dependencies"]]
    while open_ends:
        need = open_ends.pop()
        name = canonicalize_name(need.name)
        if name not in found:
            found.add(name)
            parts = [Requirement(each) for each in requires(name) or ()]
            extras = need.extras or {""}
            open_ends += [
                each for each in parts if each.marker is None or any(each.marker.evaluate({"extra": x}) for x in extras)
            ]
    return found


def test_a_module_that_is_imported_is_always_installed_or_is_brought_by_an_extra():
    owners, always = packages_distributions(), always_installed()
    by_chance = [
        module
        for module in sorted({*imported_modules()} - {*EXTRAS})
        if not {canonicalize_name(name) for name in owners.get(module, ())} & always
    ]
    assert by_chance == ["roadmend_msgs", "tf2_msgs"]  # which the set-up builds, and the wheel holds


def test_every_extra_is_named_for_a_module():
    assert {*EXTRAS.values(), "all"} == set(PROJECT["optional-dependencies"])


def test_the_extra_all_has_all_of_them():
    (every,) = PROJECT["optional-dependencies"]["all"]
    assert set(re.search(r"\[(.+)\]", every)[1].split(",")) == set(EXTRAS.values())


def test_a_module_of_a_library_is_the_librarys():
    error = ModuleNotFoundError("No module named 'matplotlib.figure'", name="matplotlib.figure")
    assert str(extra_missing(error)).endswith(
        "pip install 'roadmend[reports]', or in a clone: ./roadmend set-up reports"
    )


def test_what_no_extra_has_stays_what_it_is():
    with pytest.raises(ModuleNotFoundError, match="numpy"):
        extra_missing(ModuleNotFoundError("No module named 'numpy'", name="numpy"))


CHILD = """
import sys
sys.modules["matplotlib"] = None  # as if it were not installed
from roadmend.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


def test_a_command_that_needs_it_says_so_in_one_line_and_others_run(tmp_path):
    def call(*arguments):
        command = [sys.executable, "-c", CHILD, *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    sample = str(Path(__file__).parents[2] / "bags" / "samples" / "collision")
    refused = call("bag", "plot", sample)
    assert refused.returncode == 2
    (said,) = refused.stderr.splitlines()
    assert said.startswith("roadmend: matplotlib: needed here and not installed; install it with: pip install")
    assert call("bag", "info", sample).returncode == 0
