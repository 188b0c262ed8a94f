"""What drives never loads torch."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    "modules", ["roadmend.repair.registry, roadmend.policies.registry, roadmend.cli.run", "roadmend.nodes.repair"]
)
def test_driving_loads_no_torch(modules):
    code = f"import sys, {modules}; print(*({{'torch', 'tensorboard'}} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
