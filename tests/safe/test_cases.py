"""Reports and files of the scenario language, told apart."""

import json

import pytest

from roadmend.core.errors import InputError
from roadmend.safe.cases import gather_cases
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.dsl_file import save_crash_scenario

from .crashes import CROSSING

SUMMARY = (
    "V1, a 2004 Honda Civic four-door sedan, was traveling north on a two-lane road. V2, a 2002 Ford Explorer sport "
    "utility vehicle, was traveling south on the same road. It was dark and clear. V2 crossed the center line and the "
    "front of V2 struck the front of V1."
)


def test_files_in_every_form_and_folders_of_them(tmp_path):
    for name in ("a.json", "B.YAML", "c.safe"):
        save_crash_scenario(CROSSING, tmp_path / name)
    (tmp_path / ".git").mkdir()
    (tmp_path / "a.evidence.json").write_text("{}", encoding="utf-8")
    assert [case.name for case in gather_cases([tmp_path])] == ["B", "a"]
    assert gather_cases([tmp_path])[0].crash == CROSSING
    (case,) = gather_cases([tmp_path / "c.safe"])
    assert (case.name, case.crash) == ("c", CROSSING)


def test_a_report_and_a_folder_of_reports(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "summary.txt").write_text(SUMMARY, encoding="utf-8")
    (tmp_path / "one" / "oracle.json").write_text("{}", encoding="utf-8")
    first, second = gather_cases([tmp_path])
    assert (first.name, second.name) == ("one", "two")
    assert [vehicle.initial_position for vehicle in first.crash.vehicles] == ["S2N", "N2S"]
    assert gather_cases([tmp_path / "one"]) == [first]


def test_what_cannot_be_read_is_a_case_with_its_problem(tmp_path):
    (tmp_path / "bad.json").write_text(json.dumps(dump_data(CROSSING) | {"num_lanes": 0}), encoding="utf-8")
    (tmp_path / "binary").mkdir()
    (tmp_path / "binary" / "summary.txt").write_bytes(bytes(range(32)) * 9)
    cases = gather_cases([tmp_path / "bad.json", tmp_path / "binary"])
    assert [case.crash for case in cases] == [None, None]
    assert "num_lanes" in cases[0].problem
    assert "is no text" in cases[1].problem


def test_nothing_there_and_two_of_one_name_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such"):
        gather_cases([tmp_path / "missing"])
    with pytest.raises(InputError, match="holds no report"):
        gather_cases([tmp_path])
    for name in ("x.json", "x.yaml"):
        save_crash_scenario(CROSSING, tmp_path / name)
    with pytest.raises(InputError, match="two cases 'x'"):
        gather_cases([tmp_path])
