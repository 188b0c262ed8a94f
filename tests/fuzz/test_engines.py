"""Both engines give files to a reader, tell of each fault, and keep what they found."""

import json

import pytest
import run as fuzz_run

import fuzz_engines
import fuzz_readers
from fuzz_readers import READERS, Reader

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
    found = fuzz_run.fuzz(name, SECONDS, 1, engine)
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


def test_only_the_engine_that_knows_what_it_reached_can_keep_it(capsys):
    with pytest.raises(SystemExit):
        fuzz_run.main(["json", "1", "--keep"])
    assert "--keep is of --engine atheris" in capsys.readouterr().err
