"""What a bag says about the run that made it."""

import hashlib
import json
from pathlib import Path

import pytest

from roadmend import __version__
from roadmend.networks.checkpoint import models_folder
from roadmend.nodes.provenance import provenance


def told(policy="modular", method="rss", given=()):
    return provenance(Path("a/s.yaml"), policy, method, "lockstep", 7, given)


def digest(name):
    return hashlib.sha256((models_folder() / f"{name}.safetensors").read_bytes()).hexdigest()


def test_who_drove_with_what():
    known = told(given=("-p", "rss.rho:=0.4"))
    assert {name: known[name] for name in ("scenario_file", "policy", "method", "clock", "seed")} == {
        "scenario_file": "s.yaml",
        "policy": "modular",
        "method": "rss",
        "clock": "lockstep",
        "seed": "7",
    }
    assert known["roadmend"] == __version__
    assert known["ros_arguments"] == "-p rss.rho:=0.4"
    assert json.loads(known["method_defaults"])["time_gap"] == pytest.approx(0.5)
    assert "libsumo" in known
    assert not any(name.endswith("sha256") for name in known)


def test_models_are_named_with_their_digests():
    known = told("neural", "adreft")
    assert (known["policy_model"], known["policy_model_sha256"]) == ("neural", digest("neural"))
    assert (known["method_model"], known["method_model_sha256"]) == ("modular", digest("adreft-modular"))


@pytest.mark.parametrize("word", ["adreft.model:={}", "repair_node:adreft.model:={}", "adreft.model:='{}'"])
def test_a_model_that_an_argument_chooses(word, tmp_path):
    other = tmp_path / "other.safetensors"
    other.write_bytes(b"weights")
    known = told(method="adreft", given=("-p", word.format(other)))
    assert known["method_model_sha256"] == hashlib.sha256(b"weights").hexdigest()


def test_what_is_not_there_has_no_digest():
    assert told(method="model", given=("-p", "model.model:=absent"))["method_model_sha256"] == ""
    assert "method_defaults" not in told(method="absent")
