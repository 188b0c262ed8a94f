"""Scenarios on disk: what is written reads back, and every fault is one line that names file, field and mend."""

import json

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import dump_scenario, load_scenario, save_scenario, scenario_schema


@pytest.fixture
def content():
    return yaml.safe_load(dump_scenario(sample_scenario("S3", 7)))


def fault_of(path, content):
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    with pytest.raises(InputError) as caught:
        load_scenario(path)
    text = str(caught.value)
    assert str(path) in text
    assert "\n" not in text
    return text


@pytest.mark.parametrize("family", FAMILIES)
def test_a_saved_scenario_reads_back_equal(family, tmp_path):
    scenario = sample_scenario(family, 3)
    save_scenario(scenario, tmp_path / "s.yaml")
    assert load_scenario(tmp_path / "s.yaml") == scenario
    assert load_scenario(tmp_path / "s.yaml").digest == scenario.digest


@pytest.mark.parametrize("family", FAMILIES)
def test_sampling_depends_on_family_and_seed_only(family):
    assert sample_scenario(family, 5) == sample_scenario(family, 5)
    assert sample_scenario(family, 5).digest != sample_scenario(family, 6).digest


def test_an_unknown_family_names_the_known_ones():
    with pytest.raises(InputError, match="S1, S2, S3, S4, S5"):
        sample_scenario("S9", 1)


def test_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_scenario(tmp_path / "none.yaml")


def test_broken_yaml_names_the_line(tmp_path):
    assert "line 3" in fault_of(tmp_path / "s.yaml", "name: x\nego: [1, 2\nactors: }")


def test_an_empty_file(tmp_path):
    assert "holds no fields" in fault_of(tmp_path / "s.yaml", "")


def test_binary_content(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match="cannot be read"):
        load_scenario(path)


def test_an_unknown_field_is_named(tmp_path, content):
    content["weather_today"] = "fine"
    assert "field weather_today is unknown" in fault_of(tmp_path / "s.yaml", content)


def test_a_seed_that_is_text_is_refused(tmp_path, content):
    content["seed"] = "seven"
    text = fault_of(tmp_path / "s.yaml", content)
    assert "field seed" in text
    assert '"seven"' in text


def test_two_actors_of_one_name(tmp_path, content):
    content["actors"].append(content["actors"][0])
    assert "used twice" in fault_of(tmp_path / "s.yaml", content)


@pytest.mark.parametrize("name", ["north", "centre"])
def test_arms_have_names_of_their_own(tmp_path, content, name):
    names = ["south", "north", name]
    content["network"] = {"kind": "intersection", "arms": [{"name": each, "bearing": 0.0} for each in names]}
    assert f"arm '{name}' has a name that is taken" in fault_of(tmp_path / "s.yaml", content)


def test_a_nested_field_is_named_with_its_place(tmp_path, content):
    content["actors"][1]["depart"] = -1
    assert "actors[1].vehicle.depart" in fault_of(tmp_path / "s.yaml", content)


def test_a_truth_value_is_no_number(tmp_path, content):
    content["ego"]["speed"] = yaml.safe_load("yes")
    text = fault_of(tmp_path / "s.yaml", content)
    assert "field ego: speed: true is no number" in text


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([[0.0, 1.0], [float("nan"), 2.0]], "points[1]"),
        ([[0.0, 1.0], [5.0, True]], "points[1]"),
        ([[0.0, 1.0], [5.0, 2e6]], "points[1]"),
        ([[0.0, 1.0], [5.0, 2.0], [5, 2]], "points[1] and points[2] are one place"),
    ],
)
def test_a_line_to_follow_has_points_that_lead_on(tmp_path, content, points, said):
    follow = {"action": "follow", "when": {"time": 1.0}, "speed": 3.0, "points": points}
    content["actors"][0]["manoeuvres"] = [follow]
    assert said in fault_of(tmp_path / "s.yaml", content)
    follow["points"] = [[0, 1], [5.0, 2.0]]
    (tmp_path / "s.yaml").write_text(yaml.safe_dump(content))
    assert load_scenario(tmp_path / "s.yaml").actors[0].manoeuvres[0].points == [(0.0, 1.0), (5.0, 2.0)]


@pytest.mark.parametrize("bearings", [(90.0, 90.0), (0.0, 360.0), (-90.0, 270.2)])
def test_two_arms_do_not_lie_one_upon_the_other(tmp_path, content, bearings):
    for arm, bearing in zip(content["network"]["arms"], bearings, strict=False):
        arm["bearing"] = bearing
    assert "lie one upon the other; give them other bearings" in fault_of(tmp_path / "s.yaml", content)


@pytest.mark.parametrize("kind", ["file", "sumocfg"])
def test_a_path_is_a_name_that_a_file_may_have(tmp_path, content, kind):
    content["network"] = {"kind": kind, "path": "a\0b"}
    assert "path" in fault_of(tmp_path / "s.yaml", content)


def test_not_a_number_is_no_number(tmp_path, content):
    content["time_limit"] = float("nan")
    assert "time_limit" in fault_of(tmp_path / "s.yaml", content)


def test_nothing_half_written_where_the_folder_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        save_scenario(sample_scenario("S1", 1), tmp_path / "file" / "s.yaml")


def test_the_schema_is_one(content):
    schema = json.loads(json.dumps(scenario_schema()))
    assert set(Scenario.model_fields) <= set(schema["properties"])
    assert schema["additionalProperties"] is False
