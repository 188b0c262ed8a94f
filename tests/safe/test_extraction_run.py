"""Many reports: what goes wrong with one of them leaves the others alone, and so are files of somebody else's."""

import json
from pathlib import Path

import pytest

from roadmend.core.errors import ForeignError, InputError
from roadmend.safe.dsl_file import dump_crash_scenario
from roadmend.safe.extraction import Extraction
from roadmend.safe.extraction_run import extract_reports

from .crashes import CROSSING


class Extracting:
    """Fails at one of the reports."""

    def __init__(self, error):
        self.error = error

    def extract(self, report, watch=None):
        if report.case == "b":
            raise self.error
        return Extraction(CROSSING, {}, "there is none")


@pytest.fixture
def run(tmp_path):
    paths = [tmp_path / f"{name}.txt" for name in "abc"]
    for path in paths:
        path.write_text("V1 hit V2.")
    return lambda error: list(extract_reports(paths, Extracting(error), [], tmp_path / "out", 1))


def test_a_backend_of_ones_own_that_fails_fails_for_that_report(run):
    done = {
        each.case: each.error for each in run(ForeignError("backend own:Model", "KeyError: 'lost'", "mend the class"))
    }
    assert done.keys() == {*"abc"}
    assert [done["a"], done["c"]] == [None, None]
    assert done["b"].endswith("b.txt: backend own:Model: KeyError: 'lost'; mend the class")


def test_what_every_report_needs_ends_the_run(run):
    with pytest.raises(InputError, match="not installed"):
        run(InputError("the parser", "is not installed", "install it"))


def test_what_fails_now_does_not_leave_what_was_read_before(run, tmp_path):
    run(ForeignError("backend", "is away", "wait"))
    out = tmp_path / "out"
    (out / "a.html").write_text("a page")
    assert (out / "a.json").is_file()
    assert all(not each.is_new for each in run(ForeignError("backend", "is away", "wait")) if each.case != "b")
    (tmp_path / "a.txt").rename(tmp_path / "b.txt")
    (tmp_path / "a.txt").write_text("")
    assert {each.case for each in run(ForeignError("backend", "is away", "wait")) if each.error} == {"a", "b"}
    assert not [*out.glob("a.*")]


def test_another_setting_reads_anew(tmp_path):
    (tmp_path / "a.txt").write_text("V1 hit V2.")
    for setting, is_new in (("network 1", True), ("network 1", False), ("network 2", True)):
        (done,) = extract_reports([tmp_path / "a.txt"], Extracting(None), [setting], tmp_path / "out", 1)
        assert done.is_new == is_new


def test_files_that_no_call_wrote_stay_where_a_report_fails(tmp_path):
    (tmp_path / "a.txt").write_text("")
    for name in ("a.json", "a.html", "a.evidence.json"):
        (tmp_path / name).write_text("{}")
    (done,) = extract_reports([tmp_path / "a.txt"], Extracting(None), [], tmp_path, 1)
    assert "is empty" in done.error
    assert len([*tmp_path.iterdir()]) == 4


def test_a_scenario_that_was_changed_since_it_was_read_is_named_and_stays(tmp_path):
    def extract(setting):
        return next(iter(extract_reports([tmp_path / "a.txt"], Extracting(None), [setting], tmp_path / "out", 1)))

    (tmp_path / "a.txt").write_text("V1 hit V2.")
    assert extract("one").is_new
    file = tmp_path / "out" / "a.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps(content, indent=8))
    assert not extract("one").is_new, "in another layout it is the same"
    edited = json.dumps(content | {"num_lanes": 6})
    file.write_text(edited)
    for setting in ("one", "two"):
        found = extract(setting)
        assert found.scenario is None
        assert found.error.startswith(f"{file}: is no longer what was read from {tmp_path / 'a.txt'}; ")
    (tmp_path / "a.txt").write_text("")
    assert "is empty" in extract("one").error
    assert file.read_text() == edited
    (tmp_path / "a.txt").write_text("V1 hit V2.")
    file.unlink()
    assert extract("one").scenario == content


def test_a_scenario_that_was_changed_with_a_slip_stays(tmp_path):
    (tmp_path / "a.txt").write_text("V1 hit V2.")
    list(extract_reports([tmp_path / "a.txt"], Extracting(None), [], tmp_path / "out", 1))
    file = tmp_path / "out" / "a.json"
    edited = file.read_text().replace("}", "},,", 1)
    file.write_text(edited)
    (found,) = extract_reports([tmp_path / "a.txt"], Extracting(None), [], tmp_path / "out", 1)
    assert f"{file}: is no longer what was read from" in found.error
    assert file.read_text() == edited


@pytest.mark.parametrize("content", [dump_crash_scenario(CROSSING, ".json"), "{}", "notes"])
def test_a_scenario_that_no_call_wrote_is_named_and_stays(content, tmp_path):
    (tmp_path / "a.txt").write_text("V1 hit V2.")
    file = tmp_path / "a.json"
    file.write_text(content)
    (found,) = extract_reports([tmp_path / "a.txt"], Extracting(None), [], tmp_path, 1)
    assert found.error.startswith(f"{file}: is there, and was not read from {tmp_path / 'a.txt'}; ")
    assert file.read_text() == content
    assert len([*tmp_path.iterdir()]) == 2


def test_what_a_kill_leaves_between_the_files_is_done_again(tmp_path, monkeypatch):
    def die_before_scenario(beside, path):
        if path.name == "a.json":
            raise KeyboardInterrupt
        return renamed(beside, path)

    (tmp_path / "a.txt").write_text("V1 hit V2.")
    renamed = Path.replace
    monkeypatch.setattr(Path, "replace", die_before_scenario)
    with pytest.raises(KeyboardInterrupt):
        list(extract_reports([tmp_path / "a.txt"], Extracting(None), [], tmp_path / "out", 1))
    monkeypatch.undo()
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a.evidence.json"]
    (done,) = extract_reports([tmp_path / "a.txt"], Extracting(None), [], tmp_path / "out", 1)
    assert done.error is None
