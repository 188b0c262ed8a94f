"""Tests of all methods need a model for those that run one; where none ships yet, one with random weights serves."""

import pytest

from roadmend.networks import checkpoint as shipped

from .tiny_model import save_tiny_model


@pytest.fixture(autouse=True)
def _any_model(tmp_path, monkeypatch):
    if not (shipped.models_folder() / "adreft-modular.safetensors").is_file():
        save_tiny_model(tmp_path / "models" / "adreft-modular.safetensors")
        monkeypatch.setattr(shipped, "models_folder", lambda: tmp_path / "models")
