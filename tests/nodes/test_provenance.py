"""What a bag says about what drove and repaired: read off the objects, not off what was asked for."""

import hashlib
from pathlib import Path

import pytest

from roadmend import __version__
from roadmend.networks.checkpoint import models_folder
from roadmend.nodes.provenance import described, provenance
from roadmend.policies.registry import POLICY_REGISTRY, make_policy
from roadmend.repair.registry import METHOD_REGISTRY, make_method
from tests.core.own_code import METHOD


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def of_method(given, **parameters):
    return described(METHOD_REGISTRY.find(given), make_method(given, parameters), parameters)


def test_what_no_node_can_tell():
    known = provenance(Path("a/s.yaml"), ("-p", "rss.rho:=0.4"))
    assert (known["scenario_file"], known["ros_arguments"]) == ("s.yaml", "-p rss.rho:=0.4")
    assert known["roadmend"] == __version__
    assert "libsumo" in known


def test_a_policy_without_a_model():
    known = described(POLICY_REGISTRY.find("modular"), make_policy("modular"), {})
    assert known == {"class": "roadmend.policies.modular.ModularPolicy", "package": f"roadmend {__version__}"}


@pytest.mark.parametrize(
    ("method", "file", "threshold"),
    [("adreft", "adreft-neural", 0.3), ("gated", "adreft-neural", 0.3), ("model", "self_oracle-neural", None)],
)
def test_a_model_by_name_has_the_digest_of_what_was_loaded(method, file, threshold):
    known = of_method(method, model="neural")
    assert known["model"] == "neural"
    assert known["model_sha256"] == digest(models_folder() / f"{file}.safetensors")
    assert float(known["threshold"]) == (threshold or pytest.approx(0.5796859))


def test_a_model_by_its_path_and_a_threshold_that_was_given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("m.safetensors").write_bytes((models_folder() / "adreft-modular.safetensors").read_bytes())
    known = of_method("adreft", model="m.safetensors", threshold=0.25)
    assert (known["model"], known["threshold"]) == (str(tmp_path / "m.safetensors"), "0.25")
    assert known["model_sha256"] == digest(tmp_path / "m.safetensors")


def test_code_from_outside_says_where_it_comes_from(own):
    name = own(METHOD)
    known = of_method(f"{name}:Near")
    assert known["class"] == f"{name}.Near"
    assert known["package"] == f"{name}, not installed"
    assert known["origin"] == str(Path(f"{name}.py").resolve())
    assert len(known["code_sha256"]) == 64
