"""The commands build, test, reproduce and export of ``roadmend safe``, as a user calls them."""

import json

import pytest
from PIL import Image

from roadmend.cli import safe
from roadmend.cli.main import main
from roadmend.safe.driving import CrashTestResult
from roadmend.world.scenario_file import load_scenario

from .head_on import HEAD_ON, write_report


@pytest.fixture
def report(tmp_path):
    return write_report(tmp_path / "reports")


@pytest.fixture
def crash(tmp_path):
    path = tmp_path / "head-on.json"
    path.write_text(json.dumps(HEAD_ON), encoding="utf-8")
    return path


def run(capsys, *arguments):
    code = main([*map(str, arguments)])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_build_writes_scenarios_that_load(crash, tmp_path, capsys):
    out = tmp_path / "out"
    code, text, _ = run(capsys, "safe", "build", crash, "--out", out, "--samples", 1, "--workers", 1, "--json")
    content = json.loads(text)
    assert code == 0
    assert (content["reports"], content["built"], content["failed"]) == (1, 1, {})
    assert [load_scenario(out / name).origin.vehicle for name in content["scenarios"]] == [1, 2]


def test_a_test_writes_its_report_with_pictures_beside_the_sketch_and_goes_on(report, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ("safe", "test", report, "--out", out, "--samples", 1, "--workers", 1, "--json")
    code, text, _ = run(capsys, *arguments)
    assert code == 0
    found = json.loads(text)["modular"]
    assert (found["reports"], found["built"], found["scenarios"]) == (1, 1, 2)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "pictures/sketch-head-on.png" in page
    for name in ("head-on-v1-0-modular.png", "head-on-v2-0-modular.png", "sketch-head-on.png"):
        assert f"pictures/{name}" in page
        Image.open(out / "pictures" / name).verify()
    assert "paper: IDM" in (out / "report.md").read_text(encoding="utf-8")
    done = (out / ".work" / "results.jsonl").read_bytes()
    assert run(capsys, *arguments)[1] == text
    assert (out / ".work" / "results.jsonl").read_bytes() == done, "nothing was done again"
    (out / "pictures" / "head-on-v2-0-modular.png").unlink()
    assert run(capsys, *arguments)[0] == 0
    assert (out / "pictures" / "head-on-v2-0-modular.png").is_file(), "what has gone is made again"


def test_a_test_says_why_an_episode_could_not_be_driven(crash, tmp_path, capsys, monkeypatch):
    idle = CrashTestResult("head-on", 1, "modular", note="policy mine:Own: failed in step")
    monkeypatch.setattr(safe, "do_all", lambda *_: [idle])
    arguments = ("safe", "test", crash, "--out", tmp_path / "out", "--no-pictures", "--workers", 1)
    for more in ((), ("--json",)):
        code, _, error = run(capsys, *arguments, *more)
        assert (code, error) == (1, "head-on, vehicle 1, modular: policy mine:Own: failed in step\n")


def test_reproduce_finds_the_crash_and_names_the_report(crash, tmp_path, capsys):
    out = tmp_path / "out"
    code, text, _ = run(
        capsys, "safe", "reproduce", crash, "--out", out, "--budget", 20, "--no-pictures", "--workers", 1, "--json"
    )
    found = json.loads(text)["modular"]
    assert code == 0
    assert (found["reproduced"], found["names"]) == (1, ["head-on"])
    assert load_scenario(out / "scenarios" / "head-on-v1-reproduced-modular.yaml").origin.report == "head-on"
    assert "what no policy is asked" in (out / "reproduction.md").read_text(encoding="utf-8")


def test_reproduce_says_by_its_code_that_a_report_could_not_be_read(crash, tmp_path, capsys):
    broken = tmp_path / "broken.json"
    broken.write_text("{", encoding="utf-8")
    arguments = ("safe", "reproduce", crash, broken, "--out", tmp_path / "out", "--budget", 1, "--no-pictures")
    for more in ((), ("--json",)):
        code, text, error = run(capsys, *arguments, "--workers", 1, *more)
        assert code == 1
        assert "broken" in error
        assert text


def test_reproduce_says_so_too_where_no_role_runs(crash, tmp_path, capsys, monkeypatch):
    idle = CrashTestResult("head-on", 1, "modular", note="cannot be built", reproduced=False)
    monkeypatch.setattr(safe, "do_all", lambda *_: [idle])
    arguments = ("safe", "reproduce", crash, "--out", tmp_path / "out", "--no-pictures", "--workers", 1)
    code, _, error = run(capsys, *arguments)
    assert code == 1
    assert "head-on" in error
    assert error.endswith(": cannot be built\n")


def test_reproduce_is_done_where_every_role_ran_and_nobody_touched_anybody(crash, tmp_path, capsys, monkeypatch):
    missed = CrashTestResult(
        "head-on", 1, "modular", note="no contact; the nearest was 0.9 m", reproduced=False, episodes=9
    )
    monkeypatch.setattr(safe, "do_all", lambda *_: [missed])
    arguments = ("safe", "reproduce", crash, "--out", tmp_path / "out", "--no-pictures", "--workers", 1)
    assert run(capsys, *arguments)[0::2] == (0, "")


def test_export_writes_both_formats(crash, tmp_path, capsys):
    out = tmp_path / "out"
    run(capsys, "safe", "build", crash, "--out", out, "--samples", 1, "--workers", 1)
    code, text, _ = run(capsys, "safe", "export", out / "scenarios" / "head-on-v1-0.yaml", "--out", out, "--json")
    assert code == 0
    assert {*json.loads(text)} == {"openscenario", "opendrive"}
    assert (out / "head-on-v1-0.xosc").is_file()


def test_a_report_that_cannot_be_read_is_named_and_the_others_are_built(report, tmp_path, capsys):
    (report / "empty").mkdir()
    (report / "empty" / "summary.txt").write_text("", encoding="utf-8")
    out = tmp_path / "out"
    code, text, error = run(capsys, "safe", "build", report, "--out", out, "--samples", 1, "--workers", 1)
    assert code == 1
    assert "empty" in error
    assert "2 scenarios from 1 of 2 reports" in text


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("missing.json", None, "no such"),
        ("broken.json", "{", "broken.json"),
        ("strange.json", '{"road_type": "Roundabout"}', "strange.json"),
    ],
)
def test_what_cannot_be_used_is_one_line_and_exit_code_2(name, content, words, tmp_path, capsys):
    if content is not None:
        (tmp_path / name).write_text(content, encoding="utf-8")
    code, _, error = run(capsys, "safe", "build", tmp_path / name, "--out", tmp_path / "out", "--workers", 1)
    assert code == 2
    assert words in error
    assert error.count("\n") == 1
    assert "Traceback" not in error
    assert not (tmp_path / "out").exists()


def test_two_cases_of_one_name_are_refused(crash, report, tmp_path, capsys):
    code, _, error = run(capsys, "safe", "build", crash, report, "--out", tmp_path / "out", "--workers", 1)
    assert code == 2
    assert "two cases 'head-on'" in error


def test_reproduce_is_judged_by_records(crash, tmp_path, capsys):
    records, out = tmp_path / "records", tmp_path / "out"
    records.mkdir()
    vehicles = [{"number": 1, "from": "E", "to": "E"}, {"number": 2, "from": "W", "to": "W"}]
    hit = {"striking": 2, "struck": 1, "striking_part": "front", "struck_part": "front"}
    record = {"crash": {"road": "Straight", "vehicles": vehicles, "collisions": [hit]}}
    (records / "head-on.json").write_text(json.dumps(record), encoding="utf-8")
    arguments = ("safe", "reproduce", crash, "--out", out, "--budget", 20, "--no-pictures", "--workers", 1)
    code, text, _ = run(capsys, *arguments, "--crash-records", records, "--json")
    assert code == 0
    assert json.loads(text)["modular"]["by_records"]["names"] == ["head-on"]
    page = (out / "reproduction.md").read_text(encoding="utf-8")
    assert "| head-on | 1 | modular | reproduced |" in page
    judged = json.loads((out / "judged.json").read_text(encoding="utf-8"))
    assert [run["failed"] for run in judged] == [{}, None]
    vehicles[0]["from"] = "N"
    (records / "head-on.json").write_text(json.dumps(record), encoding="utf-8")
    code, text, _ = run(capsys, *arguments, "--crash-records", records)
    assert "| head-on | 1 | modular | from |" in (out / "reproduction.md").read_text(encoding="utf-8")
    assert "wrong records accepted" in text
    (records / "head-on.json").write_text("{", encoding="utf-8")
    code, _, error = run(capsys, *arguments, "--crash-records", records)
    assert (code, error.count("\n")) == (2, 1)
