"""The order of the tests: long ones first, so that the last worker at work has only short ones left. And code of users."""

import gc
import itertools
import subprocess
import sys

import pytest

from roadmend.nodes.domain import own_domain

_numbers = itertools.count()


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Writes a module of a user's into the folder that he is in; returns its name, which no other test has imported."""
    folder = tmp_path / "theirs"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", [*sys.path])

    def write(text, name=""):
        name = name or f"own_code_{next(_numbers)}"
        (folder / f"{name}.py").write_text(text)
        return name

    return write


@pytest.fixture
def domain(monkeypatch):
    """A ROS domain of its own for a test that starts nodes."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield number
        # What rclpy holds in cycles stays in the domain until it is collected, and the next test may get the same one.
        gc.collect()


@pytest.fixture
def start(domain, tmp_path):
    """Starts a Python process; what still runs after the test is killed."""
    running = []

    def run(*arguments, **options):
        process = subprocess.Popen(
            [sys.executable, *map(str, arguments)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            **options,
        )
        running.append(process)
        return process

    yield run
    for process in running:
        if process.poll() is None:
            process.kill()
            process.wait()
        for stream in (process.stdin, process.stdout, process.stderr):
            stream.close()
