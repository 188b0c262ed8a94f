"""Machine code is kept by what the kernels say, wherever it is kept."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from roadmend.core import jit


@pytest.fixture
def chosen():
    """The folder that numba keeps machine code in, after roadmend has chosen it."""
    before = numba.config.CACHE_DIR

    def chosen():
        numba.config.CACHE_DIR = ""
        jit._choose_cache()
        return numba.config.CACHE_DIR and Path(numba.config.CACHE_DIR)

    yield chosen
    numba.config.CACHE_DIR = before


def test_a_folder_that_the_user_names_has_one_folder_for_each_state_of_the_kernels(tmp_path, monkeypatch, chosen):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    (tmp_path / "mine" / "kernels-of-others").mkdir(parents=True)
    first = chosen()
    assert first.parent == tmp_path / "mine"
    monkeypatch.setattr(jit.numba, "__version__", "0.0")
    second = chosen()
    assert first != second
    assert second.parent == tmp_path / "mine"
    assert len([*(tmp_path / "mine").iterdir()]) == 3


def test_a_package_that_cannot_be_written_keeps_them_in_the_users_cache(tmp_path, monkeypatch, chosen):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path))
    in_package = chosen()
    assert in_package.parent == Path(jit.__file__).parent / "__pycache__"
    (tmp_path / "file").touch()
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "file" / "core" / "jit.py"))
    assert chosen() == tmp_path / in_package.name
    monkeypatch.setattr(jit.os, "access", lambda *_: False)
    assert not chosen()


def test_kernels_that_were_compiled_lie_in_that_folder(tmp_path):
    code = "import numpy as np; from roadmend.core.geometry import fill_corners; "
    code += "fill_corners(np.empty((4, 2)), 0.0, 0.0, 0.0, 4.0, 2.0)"
    environ = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], env=environ, check=True, timeout=300)
    [folder] = tmp_path.iterdir()
    assert folder.name.startswith("kernels-")
    assert [*folder.rglob("*.nbi")]
