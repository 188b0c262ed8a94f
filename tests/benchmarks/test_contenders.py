import shutil
from pathlib import Path

import pytest
import yaml

from harness.contenders import read_plan, resolve, resolve_monitors
from roadmend.core.errors import InputError

CONFIG = Path(__file__).parents[2] / "config"
PLAN = CONFIG.parent / "tests" / "benchmarks" / "adreft.yaml"


def test_the_plan_names_all_methods_of_the_paper_and_the_rivals():
    plan = read_plan(PLAN)
    assert {
        "none",
        "random",
        "rule",
        "model",
        "rss",
        "predictive",
        "adreft",
        "rand_r",
        "only_sl",
        "only_rl",
        "wo_sr",
        "wo_regulation",
        "hindsight",
    } <= {*plan.methods}
    assert plan.policies == ["modular", "neural"]


def folder_with(tmp_path, tuned=None):
    if tuned is not None:
        path = tmp_path / "config" / "repair" / "tuned" / "modular.yaml"
        path.parent.mkdir(parents=True)
        path.write_text(yaml.safe_dump({"methods": tuned}))
    return tmp_path / "config"


def test_tuned_parameters_are_used_by_name_and_stand_below_the_plans(tmp_path):
    tuned = {
        "predictive": {"parameters": {"horizon": 2.0, "adaptive": True}},
        "predictive_adaptive": {"parameters": {"horizon": 4.0}},
        "rule": {"parameters": {"time_to_collision": 1.5}},
    }
    names = ["rule", "rss", "predictive", "predictive_adaptive"]
    found, absent = resolve(read_plan(PLAN), folder_with(tmp_path, tuned), "modular", names)
    assert absent == []
    parameters = {each.name: each.parameters for each in found}
    assert parameters["rule"] == {"time_to_collision": 1.5}
    assert parameters["rss"] == {}
    assert parameters["predictive"] == {"horizon": 2.0, "adaptive": False}
    assert parameters["predictive_adaptive"] == {"horizon": 4.0, "adaptive": True}
    assert [each.is_tuned for each in found] == [True, False, True, True]
    assert len({each.key for each in found}) == 4


def test_what_cannot_run_is_listed_with_its_reason(tmp_path):
    found, absent = resolve(read_plan(PLAN), folder_with(tmp_path), "modular", ["none", "adreft", "hindsight"])
    assert [each.name for each in found] == ["none", "hindsight"]
    assert [(each.name, each.reason) for each in absent] == [
        ("adreft", "there is no model config/models/adreft-modular.safetensors")
    ]
    found, absent = resolve(read_plan(PLAN), folder_with(tmp_path), "imaginary", ["none", "rule"])
    assert found == []
    assert [each.reason for each in absent] == ["there is no policy 'imaginary' in this version"] * 2


def test_a_monitor_can_be_another_method_than_its_name_says(tmp_path):
    plan, folder = read_plan(PLAN), folder_with(tmp_path)
    (folder / "models" / "ablations").mkdir(parents=True)
    for name in ("adreft-modular", "adreft-precaution-modular", "self_oracle-modular"):
        shutil.copyfile(CONFIG / "models" / f"{name}.safetensors", folder / "models" / f"{name}.safetensors")
    watched = resolve_monitors(plan, folder, "modular", plan.monitors)
    assert [each.name for each in watched] == ["adreft", "adreft_precaution", "rule", "model", "rss", "predictive"]
    assert [each.title for each in watched[:3]] == ["ADReFT, where it steps in", "ADReFT, precaution too", "RuleRepair"]
    assert [each.model.stem for each in watched[:2]] == ["adreft-modular", "adreft-precaution-modular"]
    assert watched[1].key == resolve(plan, folder, "modular", ["precaution"])[0][0].key


def test_unusable_parameters_and_plans_are_refused(tmp_path):
    tuned = {"rule": {"parameters": {"time_to_collision": -1.0}}}
    with pytest.raises(InputError, match=r"rule\.time_to_collision"):
        resolve(read_plan(PLAN), folder_with(tmp_path, tuned), "modular", ["rule"])
    content = yaml.safe_load(PLAN.read_text())
    for change, expected in (
        ({"monitors": ["nobody"]}, "there is no 'nobody'"),
        ({"watched": {"adreft": {"method": "nobody", "title": "x"}}}, "there is no 'nobody'"),
        ({"methods": {"none": {"title": "x"}}}, "methods.none.method"),
        ({"surprise": 1}, "surprise"),
    ):
        path = tmp_path / "plan.yaml"
        path.write_text(yaml.safe_dump(content | change))
        with pytest.raises(InputError, match=expected):
            read_plan(path)
    path.write_text("[")
    with pytest.raises(InputError, match="broken YAML"):
        read_plan(path)
