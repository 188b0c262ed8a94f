"""Policies by name, and the file of defaults."""

from pathlib import Path

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import find_model
from roadmend.policies.parameters import ModularParameters
from roadmend.policies.prediction import TIMES, time_at
from roadmend.policies.registry import POLICIES, make_policy

CONFIG = Path(__file__).parents[2] / "config" / "policies"


def test_the_file_of_defaults_holds_the_defaults():
    values = yaml.safe_load((CONFIG / "modular.yaml").read_text())
    assert values == ModularParameters().model_dump()


def test_every_policy_is_made_by_its_name():
    for name in POLICIES:
        assert make_policy(name).name == name


def test_a_model_file_is_a_neural_policy(tmp_path):
    shipped = find_model("neural")
    assert make_policy(str(shipped)).model_digest == make_policy("neural").model_digest
    with pytest.raises(InputError, match="no such model file"):
        make_policy(str(tmp_path / "none.safetensors"))


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match="modular"):
        make_policy("nobody")


@pytest.mark.parametrize("parameters", [{"headway": -1.0}, {"haedway": 1.0}, {"headway": float("nan")}])
def test_bad_parameters_are_refused_by_name(parameters):
    with pytest.raises(InputError, match=next(iter(parameters))):
        make_policy("modular", parameters)


@pytest.mark.parametrize("name", list(ModularParameters.model_fields))
def test_every_parameter_refuses_what_is_outside_its_range(name):
    bounds = ModularParameters.model_json_schema()["properties"][name]
    low, high = bounds["minimum"], bounds["maximum"]
    assert getattr(ModularParameters(**{name: low}), name) == low
    assert getattr(ModularParameters(**{name: high}), name) == high
    for value in (low - 0.01, high + 0.01):
        with pytest.raises(InputError):
            make_policy("modular", {name: value})


def test_gaps_are_looked_for_no_further_than_is_predicted():
    bounds = ModularParameters.model_json_schema()["properties"]["change_horizon"]
    assert bounds["maximum"] == time_at(TIMES - 1)
