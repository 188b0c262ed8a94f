"""A model that decides otherwise is the same networks, and says what it was made from."""

import json

import numpy as np
import pytest

from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.repair.adreft.model import AdreftModel
from roadmend.training.adreft.adjusting import adjust

SHIPPED = find_model("modular", "adreft-")


def test_threshold_and_rules_change_and_the_networks_stay(tmp_path, capsys):
    out = tmp_path / "other.safetensors"
    words = [str(SHIPPED), "--threshold", "0.6", "--set", "longest=8.0", "--set", "hold=0.5", "--out", str(out)]
    assert main(["train", "adjust", *words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"model": str(out), "sha256": load_checkpoint(out).digest}
    before, after = load_checkpoint(SHIPPED), load_checkpoint(out)
    assert {*before.tensors} == {*after.tensors}
    assert all(np.array_equal(before.tensors[name], after.tensors[name]) for name in before.tensors)
    model = AdreftModel.load(out)
    assert (model.threshold, model.configuration.longest, model.configuration.hold) == (0.6, 8.0, 0.5)
    assert model.configuration.interval == AdreftModel.load(SHIPPED).configuration.interval
    assert after.header["ancestry"] == [before.digest, *before.header["ancestry"]]
    told = "./roadmend train adjust adreft-modular.safetensors --threshold 0.6 --set longest=8.0 --set hold=0.5"
    assert after.header["adjusted"] == {"command": told, "metrics_are_of": before.digest}


@pytest.mark.parametrize(
    ("threshold", "changes", "said"),
    [
        (1.5, {}, "--threshold: 1.5 is out of range"),
        (None, {"size": 3}, "there is no 'size'"),
        (None, {"adapter": [3]}, "there is no 'adapter'"),
        (None, {"hold": 99.0}, "hold"),
    ],
)
def test_what_makes_no_model_is_refused_and_nothing_is_written(tmp_path, threshold, changes, said):
    with pytest.raises(InputError, match=said):
        adjust(SHIPPED, tmp_path / "x.safetensors", threshold, changes, "")
    assert not [*tmp_path.iterdir()]


def test_nobody_presses_without_a_need_monitor(tmp_path):
    out = tmp_path / "x.safetensors"
    with pytest.raises(InputError, match="needs a model with a need monitor"):
        adjust(find_model("precaution-modular", "adreft-"), out, None, {"pressing": 0.2}, "")
    assert not out.exists()
