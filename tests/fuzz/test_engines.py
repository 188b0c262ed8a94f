"""Both engines give files to a reader, tell of each fault, and keep what they found."""

import json
import time
import zipfile

import pytest
import run as fuzz_run

import fuzz_account
import fuzz_engines
import fuzz_readers
from fuzz_readers import READERS, Reader
from roadmend.core.errors import InputError

SECONDS = 2.0


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """What is found goes into a folder of the test's."""
    monkeypatch.chdir(tmp_path)
    for module in (fuzz_engines, fuzz_readers):
        monkeypatch.setattr(module, "CORPUS", tmp_path)


@pytest.mark.parametrize("engine", fuzz_engines.ENGINES)
@pytest.mark.parametrize("name", ["json", "crash-text"])
def test_some_hundred_files_are_read_or_refused(engine, name):
    found = fuzz_run.fuzz([name], SECONDS, 1, engine)[name]
    assert found["faults"] == {}
    assert found["files"] > 300


@pytest.mark.parametrize("engine", fuzz_engines.ENGINES)
def test_a_reader_that_fails_is_told_of_and_its_file_is_kept(engine, monkeypatch, tmp_path, capsys):
    def read(path):
        if len(path.read_bytes()) > 9:
            raise ZeroDivisionError

    monkeypatch.setitem(READERS, "broken", Reader(".txt", read, lambda: [b"short"]))
    assert fuzz_run.main(["broken", str(SECONDS), "--engine", engine]) == 1
    (what,) = json.loads(capsys.readouterr().out.split(maxsplit=1)[1])["faults"]
    assert what.startswith("ZeroDivisionError at read:")
    (kept,) = tmp_path.glob("fault-broken-*")
    assert len(kept.read_bytes()) > 9


def test_a_reader_that_reads_nothing_is_a_fault(monkeypatch):
    calls = []

    def read(_path):
        calls.append(1)
        if len(calls) > 1:
            raise InputError("f", "is not read", "give another")

    monkeypatch.setattr(fuzz_account, "MANY", 10)
    monkeypatch.setitem(READERS, "refusing", Reader(".txt", read, lambda: [b"short"]))
    assert [*fuzz_run.fuzz(["refusing"], SECONDS / 4, 1, "mutation")["refusing"]["faults"]] == ["read nothing"]


@pytest.mark.parametrize("reading", ["work", "wait"])
def test_a_reader_that_takes_too_long_is_ended_and_told_of(reading, monkeypatch):
    def read(path):
        while len(path.read_bytes()) > 9:
            if reading == "wait":
                time.sleep(60.0)

    monkeypatch.setattr(fuzz_account, "TIME_MAX", 0.3 if reading == "work" else 60.0)
    monkeypatch.setattr(fuzz_account, "WAIT_MAX", 60 if reading == "work" else 1)
    monkeypatch.setitem(READERS, "endless", Reader(".txt", read, lambda: [b"short"]))
    (what,) = fuzz_run.fuzz(["endless"], SECONDS, 1, "mutation")["endless"]["faults"]
    assert what.startswith("took too long")


def test_several_are_read_at_once_and_told_of_in_their_order(capsys):
    found = fuzz_run.fuzz(["yaml", "json", "report"], SECONDS / 2, 1, "mutation", parallel=2)
    assert [*found] == ["yaml", "json", "report"]
    assert all(each["files"] > 30 for each in found.values())


def test_what_reached_new_code_is_where_the_next_run_begins(tmp_path):
    found = fuzz_run.fuzz(["json"], 4 * SECONDS, 1, "atheris", is_kept=True)["json"]
    kept = fuzz_readers.kept_of("json")
    assert found["found"] > 0
    assert 0 < len(kept) <= found["found"]
    assert sum(map(len, kept)) <= fuzz_engines.KEPT_BYTES
    assert {*kept} <= {*fuzz_readers.seeds_of("json")}
    (tmp_path / "found").mkdir()
    (tmp_path / "found" / "0").write_bytes(b"[]")
    fuzz_engines.keep("json", tmp_path / "found")  # what was there stays
    with zipfile.ZipFile(tmp_path / "json.zip") as archive:
        assert {*kept, b"[]"} == {archive.read(each) for each in archive.namelist()}


def test_only_the_engine_that_knows_what_it_reached_can_keep_it(capsys):
    with pytest.raises(SystemExit):
        fuzz_run.main(["json", "1", "--keep"])
    assert "--keep is of --engine atheris" in capsys.readouterr().err


def test_rows_are_published_as_they_come_and_what_has_one_is_left_out(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(fuzz_run, "PUBLISHED", tmp_path)
    assert fuzz_run.main(["json", "0.2", "--publish"]) == 0
    first = json.loads((tmp_path / "fuzz.json").read_text())["readers"]
    assert [*first] == ["json"]
    assert first["json"]["seconds"] == 0.2
    capsys.readouterr()
    monkeypatch.setattr(fuzz_run, "READERS", {name: READERS[name] for name in ("yaml", "json")})
    assert fuzz_run.main(["all", "0.2", "--publish", "--resume"]) == 0
    assert capsys.readouterr().out.startswith("yaml ")
    both = json.loads((tmp_path / "fuzz.json").read_text())["readers"]
    assert [*both] == ["yaml", "json"]
    assert both["json"] == first["json"]
    assert fuzz_run.main(["json", "0.3", "--publish", "--resume"]) == 0  # more seconds than its row has
    assert json.loads((tmp_path / "fuzz.json").read_text())["readers"]["json"]["seconds"] == 0.3


def test_only_what_is_published_can_be_resumed(capsys):
    with pytest.raises(SystemExit):
        fuzz_run.main(["json", "1", "--resume"])
    assert "--resume is of --publish" in capsys.readouterr().err
