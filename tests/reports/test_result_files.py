"""What made a figure, told by its file."""

import shutil
import subprocess
from pathlib import Path

import pytest

from roadmend import __version__
from roadmend.core.resources import clone_folder
from roadmend.reports import result_files


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A user's own repository, in which the user stands."""
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    for words in (["init", "-q"], ["-c", "user.name=u", "-c", "user.email=u@u", "commit", "-qm", "m", "--allow-empty"]):
        subprocess.run(["git", *words], cwd=tmp_path, check=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def head(folder):
    done = subprocess.run(["git", "rev-parse", "HEAD"], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_the_commit_is_that_of_the_project_wherever_the_user_stands(elsewhere):
    if not (clone_folder() / ".git").exists():
        pytest.skip("the clone is without its history, as in a container")
    made = result_files.provenance("roadmend evaluate")
    assert made["commit"] == head(clone_folder()) != head(elsewhere)
    assert f"at commit {made['commit'][:12]}" in result_files.origin(made)


def test_of_an_installed_package_its_version_is_told(elsewhere, monkeypatch):
    monkeypatch.setattr(result_files, "clone_folder", lambda: None)
    made = result_files.provenance("roadmend evaluate")
    assert (made["commit"], made["dirty"]) == (f"roadmend {__version__}", False)
    assert f"`roadmend evaluate` with roadmend {__version__} on" in result_files.origin(made)


def test_of_a_clone_without_its_history_nothing_is_made_up(elsewhere, monkeypatch):
    monkeypatch.setattr(result_files, "clone_folder", lambda: Path("/nowhere"))
    made = result_files.provenance("roadmend evaluate")
    assert (made["commit"], made["dirty"]) == ("unknown", False)


@pytest.mark.parametrize(
    ("name", "is_dirty"),
    [
        ("src/roadmend/new.py", True),
        ("src/roadmend/old.py", True),
        ("tests/benchmarks/bench_new.py", True),
        ("tests/benchmarks/harness/old.py", True),
        ("tests/benchmarks/crash_records/1.json", True),
        ("tests/benchmarks/adreft.json", False),
        ("tests/benchmarks/adreft-fresh.md", False),
        ("tests/benchmarks/chart.svg", False),
        ("README.md", False),
        ("notes/new.py", False),
    ],
)
def test_what_could_move_a_figure_makes_it_dirty_and_a_result_does_not(elsewhere, monkeypatch, name, is_dirty):
    monkeypatch.setattr(result_files, "clone_folder", lambda: elsewhere)
    for old in ("src/roadmend/old.py", "tests/benchmarks/harness/old.py", "tests/benchmarks/adreft.json", "README.md"):
        (elsewhere / old).parent.mkdir(parents=True, exist_ok=True)
        (elsewhere / old).write_text("as it was")
    subprocess.run(["git", "add", "."], cwd=elsewhere, check=True)
    subprocess.run(
        ["git", "-c", "user.name=u", "-c", "user.email=u@u", "commit", "-qm", "m"], cwd=elsewhere, check=True
    )
    assert result_files.provenance("roadmend evaluate")["dirty"] is False
    (elsewhere / name).parent.mkdir(parents=True, exist_ok=True)
    (elsewhere / name).write_text("as it is")
    assert result_files.provenance("roadmend evaluate")["dirty"] is is_dirty
