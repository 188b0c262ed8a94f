"""An episode is the same to the bit on a processor that can do less."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy._core import _multiarray_umath

HERE = Path(__file__).parent
DISPATCHED = [name for name in _multiarray_umath.__cpu_dispatch__ if _multiarray_umath.__cpu_features__[name]]
EPISODES = ("S1-violation-modular-rss", "S1-violation-neural-adreft", "S3-violation-ego_mlp-none", "town-neural-none")
DRIVE = """
import json, sys
import numpy as np
import physics
episodes = {golden.name: golden for golden in physics.episodes()}
places = np.linspace(-5.0, 9.0, 9999)
bits = np.arctan2(places, 3.0).tobytes().hex() + np.exp(places).tobytes().hex()
print(json.dumps([bits, {name: physics.drive(episodes[name]) for name in sys.argv[1:]}]))
"""


@pytest.mark.skipif(not DISPATCHED, reason="this processor can do no more than the least that NumPy asks for")
def test_the_records_hold_without_the_instructions_that_only_some_processors_have():
    environment = {**os.environ, "NPY_DISABLE_CPU_FEATURES": " ".join(DISPATCHED)}
    command = [sys.executable, "-c", DRIVE, *EPISODES]
    shown = subprocess.run(command, env=environment, cwd=HERE, capture_output=True, text=True, check=True).stdout
    bits, driven = json.loads(shown)
    kept = json.loads((HERE / "trajectories.json").read_text())
    assert {name: record["trajectory"] for name, record in driven.items()} == {
        name: kept[name]["trajectory"] for name in EPISODES
    }
    if "X86_V4" in DISPATCHED:  # else nothing was switched off that matters
        places = np.linspace(-5.0, 9.0, 9999)
        assert bits != np.arctan2(places, 3.0).tobytes().hex() + np.exp(places).tobytes().hex()
