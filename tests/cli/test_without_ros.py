"""Offline commands where there is no ROS: neither rclpy nor any message package, nor their definitions."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from roadmend.recording.definitions import find

ROOT = Path(__file__).parents[2]
COLLISION, REPAIRED = (str(ROOT / "bags" / "samples" / name) for name in ("collision", "repaired"))
DEMO = str(ROOT / "config" / "scenarios" / "demo-exit.yaml")
REPORT = str(ROOT / "config" / "reports" / "straight")
PATTERN = "cut-in at a highway exit"

COMMANDS = [  # in this order: later ones use what earlier ones made
    "bag info {collision} --json",
    "bag diff {collision} {collision}",
    "bag plot {collision} --out scene.png",
    "bag recover {collision} --out recovered",
    "bag convert recovered --out converted",
    "bag convert converted --out back",
    "bag resimulate {repaired} --repair rss --out driven",
    "bag shadow {collision} --repair rss --out shadow",
    "bag info driven --json",
    "bag diff {repaired} driven",
    "evaluate {demo} --repair rss --workers 1 --out measured",
    "search --family S4 --budget 1 --workers 1 --out found",
    "safe extract {report} --out crashes --workers 1",
    "safe test {report} --samples 1 --out tested --workers 1",
    "sera analyse {collision} --workers 1",
    "sera bank build --sample 2 --out small.bank {demo}",
    "sera bank search --bank small.bank --pattern pattern -k 1",
    "sera evaluate --scenarios 1 --record all --workers 1 --out evaluated",
]

CHILD = """
import importlib.abc
import json
import os
import sys

hidden = set(json.loads(sys.argv[1]))


class Hidden(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in hidden:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Hidden())
os.environ["AMENT_PREFIX_PATH"] = ""
sys.prefix = sys.argv[2]  # nothing is installed there: no definitions of messages

from roadmend.cli.main import main

for command in json.loads(sys.argv[3]):
    print(json.dumps([command, main(command)]), flush=True)
assert not hidden & {name.partition(".")[0] for name in sys.modules}
"""


@pytest.fixture
def hidden():
    """Names of the packages that the import contract keeps inside roadmend.nodes."""
    import tomllib

    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (ros,) = (one["forbidden_modules"] for one in contracts if one["name"] == "ROS stays in roadmend.nodes")
    return ros


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_every_offline_command_runs_without_ros(hidden, tmp_path):
    places = {"collision": COLLISION, "repaired": REPAIRED, "demo": DEMO, "report": REPORT}
    commands = [[PATTERN if word == "pattern" else word.format(**places) for word in one.split()] for one in COMMANDS]
    given = [json.dumps(hidden), str(tmp_path / "nothing"), json.dumps(commands)]
    run = subprocess.run(
        [sys.executable, "-c", CHILD, *given], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    codes = [json.loads(line) for line in run.stdout.splitlines() if line.startswith('[["')]
    expected = [int(command.startswith("bag diff {repaired}")) for command in COMMANDS]  # 1: the bags differ
    assert [code for _, code in codes] == expected, run.stderr[-3000:]
    assert run.returncode == 0, run.stderr[-3000:]


@pytest.mark.parametrize("name", ["nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage", "roadmend_msgs/msg/ScenarioEvent"])
def test_definitions_without_ros_are_the_installed_ones(name, tmp_path, monkeypatch):
    installed = find(name)
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    find.cache_clear()
    try:
        assert find(name).type_hash == installed.type_hash
    finally:
        find.cache_clear()
