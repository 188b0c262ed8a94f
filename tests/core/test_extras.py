"""What is said where a library is missing that only some commands need."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from roadmend.core.extras import EXTRAS, extra_missing

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DISTRIBUTIONS = {
    "cv2": "opencv-python-headless",
    "faiss": "faiss-cpu",
    "foxglove": "foxglove-sdk",
    "stable_baselines3": "stable-baselines3",
}  # that are not called like their module


@pytest.mark.parametrize(("module", "extra"), EXTRAS.items())
def test_the_extra_that_is_named_brings_the_module(module, extra):
    brought = [re.split(r"[<>=]", need)[0].lower() for need in PROJECT["optional-dependencies"][extra]]
    assert DISTRIBUTIONS.get(module, module) in brought


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
