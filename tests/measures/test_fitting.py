"""The model and the settings that belong to a policy, and the line that says whose they are."""

import shutil

import pytest

from roadmend.core.errors import InputError
from roadmend.measures.fitting import fitting, fitting_account
from roadmend.networks.checkpoint import load_checkpoint, models_folder, save_checkpoint
from roadmend.repair.registry import METHOD_REGISTRY


def account_of(method, policy, **instead):
    parameters = METHOD_REGISTRY.find(method).entry.parameters().model_dump()
    return fitting_account(method, policy, parameters | fitting(method, policy) | instead)


@pytest.mark.parametrize(
    ("method", "policy", "fitted", "said"),
    [
        ("adreft", "neural", {"model": "neural"}, "adreft behind neural: model neural, made for it"),
        ("adreft", "modular", {"model": "modular"}, "adreft behind modular: model modular, made for it"),
        ("gated", "neural", {"model": "neural"}, "gated behind neural: model neural, made for it"),
        (
            "adreft",
            "deep_sets",
            {},
            "adreft behind deep_sets: model modular, made for modular, since none was made for it",
        ),
        (
            "adreft",
            "external",
            {},
            "adreft behind external: model modular, made for modular, since none was made for it",
        ),
        ("adreft", "a.b:C", {}, "adreft behind a.b:C: model modular, made for modular, since none was made for it"),
        (
            "rss",
            "neural",
            {"rho": 1.0, "a_min_brake": 4.0, "time_gap": 0.6},
            "rss behind neural: settings tuned for it (rho 1.0, a_min_brake 4.0, time_gap 0.6)",
        ),
        ("rss", "ego_mlp", {}, "rss behind ego_mlp: its default settings, since none were tuned for it"),
        ("none", "neural", {}, ""),
        ("governor", "neural", {}, ""),
    ],
)
def test_what_was_made_for_a_policy_is_taken_and_said(method, policy, fitted, said):
    assert fitting(method, policy) == fitted
    assert account_of(method, policy) == said


def test_what_was_given_instead_is_said():
    assert account_of("adreft", "neural", model="modular") == "adreft behind neural: model modular, made for modular"
    assert account_of("rss", "neural", rho=0.4).endswith(", but given rho 0.4")


def test_a_policy_by_its_model_file_is_known_by_its_digest(tmp_path):
    same, other = tmp_path / "same.safetensors", tmp_path / "other.safetensors"
    shutil.copy(models_folder() / "neural.safetensors", same)
    shipped = load_checkpoint(same)
    save_checkpoint(other, shipped.tensors, {**shipped.header, "metrics": {}})
    assert account_of("adreft", str(same)).endswith("model neural, made for it")
    assert fitting("rss", str(same))
    assert account_of("adreft", str(other)).endswith(
        "model neural, made for another model of neural, since none was made for it"
    )
    assert fitting("rss", str(other)) == {}


@pytest.mark.parametrize("kind", ["adreft", "self_oracle"])
@pytest.mark.parametrize("policy", ["modular", "neural"])
def test_a_model_file_that_is_named_stays(kind, policy):
    given = str(models_folder() / f"{kind}-modular.safetensors")
    assert "model" not in fitting(given, policy)
    assert f"model {given}, made for modular" in account_of(given, "neural")


def test_a_policy_that_there_is_not_is_refused():
    with pytest.raises(InputError, match="did you mean modular"):
        fitting("adreft", "modulr")
