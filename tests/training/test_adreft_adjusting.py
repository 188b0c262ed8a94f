"""A model that decides otherwise is the same networks, and says what it was made from."""

import json
import shutil

import numpy as np
import pytest

from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.repair.adreft.model import AdreftModel
from roadmend.training.adreft.adjusting import adjust
from roadmend.training.adreft.successor import save_successor

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
        (None, {"weighing": None}, "weighing: the adapter of adreft-modular.safetensors foresees collisions"),
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


def test_an_adapter_that_gives_values_gets_no_prices(tmp_path):
    prices = AdreftModel.load(SHIPPED).configuration.weighing.model_dump(mode="json")
    paper = find_model("modular", "ablations/adreft_paper-")
    with pytest.raises(InputError, match=r"weighing: the adapter of adreft_paper-modular\.safetensors gives values"):
        adjust(paper, tmp_path / "x.safetensors", None, {"weighing": prices}, "")


def test_a_model_may_take_its_own_place_and_stays_where_it_cannot(tmp_path):
    own = tmp_path / "own.safetensors"
    shutil.copy(SHIPPED, own)
    whole = own.read_bytes()
    assert main(["train", "adjust", str(own), "--set", "weighing=null", "--out", str(own)]) == 2
    parent = load_checkpoint(own)
    configuration = AdreftModel.load(own).configuration
    with pytest.raises(InputError, match="train the model again"):
        save_successor(own, parent, parent.tensors, configuration.model_copy(update={"weighing": None}))
    assert own.read_bytes() == whole
    assert main(["train", "adjust", str(own), "--threshold", "0.6", "--out", str(own)]) == 0
    assert AdreftModel.load(own).threshold == 0.6
