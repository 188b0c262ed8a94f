"""Commands that write, pointed at what is somebody else's: the whole tree is as it was, and nothing is half written."""

import errno
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from roadmend.cli import options
from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.core.whole_file import write_texts, written_beside

SAMPLES = Path(__file__).parents[2] / "bags" / "samples" / "collision"
CRASH = Path(__file__).parents[1] / "fuzz" / "corpus" / "crash.dsl"
MODEL = Path(__file__).parents[2] / "config" / "models" / "adreft-modular.safetensors"
FILES = {  # commands that write a file
    "sample": ("sample", "--family", "S3", "--out", "{}"),
    "adjust": ("train", "adjust", str(MODEL), "--threshold", "0.5", "--out", "{}"),
    "bank": ("sera", "bank", "build", "--sample", "2", "--out", "{}"),
    "export": ("sera", "bank", "export", "--bank", "own.bank", "--out", "{}"),
}
FOLDERS = {  # commands that write a folder
    "recover": ("bag", "recover", str(SAMPLES), "--out", "{}"),
    "convert": ("bag", "convert", str(SAMPLES), "--out", "{}"),
}
RESULTS = {  # commands that put files into a folder, beside what is there
    "extract": ("safe", "extract", "report.txt", "--out", "{}"),
    "export as ASAM": ("safe", "export", "crash.dsl", "--out", "{}"),
}
MENTIONED = {  # somebody's own files that speak of roadmend
    "script": b"#!/bin/sh\nroadmend sample --family S3 --out s.yaml\ncat <<EOF\nformat: roadmend-scenario/1\nEOF\n",
    "settings": b"scenario: {format: roadmend-scenario/1}\n",
    "lines": b'{"name": "mine"}\n{"format": "roadmend-corpus/3"}\n',
    "database": b"SQLite format 3\0" + bytes(84) + b"roadmend-bank/1",
}
PLACES = {
    "file": "foreign/text",
    "folder": "foreign",
    "link to a file": "link-to-text",
    "link to a folder": "link-to-folder",
    "link to nowhere": "link-to-nowhere",
    "file in the middle": "foreign/text/deeper/out",
    "device": "/dev/null",
    "pipe": "pipe",
}


def tree(folder):
    """Every name with its kind, target or digest."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink():
            found[name] = str(path.readlink())
        elif path.is_file():
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        else:
            found[name] = oct(path.lstat().st_mode)
    return found


@pytest.fixture
def theirs(tmp_path, monkeypatch):
    (tmp_path / "foreign" / "inner").mkdir(parents=True)
    (tmp_path / "foreign" / "text").write_text("theirs")
    (tmp_path / "foreign" / ".hidden").write_bytes(bytes(1000))
    (tmp_path / "foreign" / "inner" / "more").write_text("theirs too")
    (tmp_path / "link-to-text").symlink_to("foreign/text")
    (tmp_path / "link-to-folder").symlink_to("foreign")
    (tmp_path / "link-to-nowhere").symlink_to("nowhere")
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def bank(tmp_path_factory):
    from roadmend.sera.bank import build_bank
    from roadmend.sera.describe import entry_of
    from roadmend.world.families import sample_scenario

    path = tmp_path_factory.mktemp("bank") / "own.bank"
    build_bank(path, [entry_of(sample_scenario("S3", 1), "made")])
    return path.read_bytes()


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("command", FILES | FOLDERS)
def test_what_was_there_stays_as_it_was(command, place, theirs, bank, capfd):
    (theirs / "own.bank").write_bytes(bank)
    before, device = tree(theirs), os.lstat("/dev/null")
    code = main([word.format(PLACES[place]) for word in (FILES | FOLDERS)[command]])
    lines = [line for line in capfd.readouterr().err.splitlines() if line.startswith("roadmend: ")]
    assert code in {1, 2}
    assert len(lines) == 1
    assert tree(theirs) == before
    assert (os.lstat("/dev/null").st_mode, os.lstat("/dev/null").st_rdev) == (device.st_mode, device.st_rdev)


@pytest.mark.parametrize("command", FILES)
def test_an_own_earlier_file_makes_room(command, theirs, bank):
    (theirs / "own.bank").write_bytes(bank)
    before = tree(theirs)
    for _ in range(2):
        assert main([word.format("new/mine") for word in FILES[command]]) == 0
    assert sorted(tree(theirs).keys() - before.keys()) == ["new", "new/mine"]


@pytest.mark.parametrize("content", MENTIONED)
def test_a_file_that_only_speaks_of_roadmend_is_somebody_elses(content, theirs, capfd):
    (theirs / "foreign" / "text").write_bytes(MENTIONED[content])
    before = tree(theirs)
    assert main(["sample", "--family", "S3", "--out", "foreign/text"]) == 2
    assert "was not written by roadmend" in capfd.readouterr().err
    assert tree(theirs) == before


@pytest.mark.parametrize("name", ["models/neural.safetensors", "corpora/modular.jsonl", "repair/tuned/modular.yaml"])
def test_files_that_take_long_to_make_are_known_as_own(name):
    shipped = config_folder() / name
    assert options.only_own(None, None, shipped) == shipped


def test_a_file_that_cannot_be_read_is_nobodys_to_replace(theirs, monkeypatch, capfd):
    def refuse(path):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr(options, "open_regular", refuse)  # root, as whom tests may run, reads everything
    before = tree(theirs)
    assert main(["sample", "--family", "S3", "--out", "foreign/text"]) == 2
    assert "foreign/text: is there already and cannot be read; choose another name" in capfd.readouterr().err
    assert tree(theirs) == before


@pytest.mark.parametrize("command", FOLDERS)
def test_an_own_earlier_bag_does_not(command, theirs):
    given = [word.format("new/mine") for word in FOLDERS[command]]
    assert main(given) == 0
    before = tree(theirs)
    assert main(given) == 2
    assert tree(theirs) == before


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("command", RESULTS)
def test_results_take_the_place_of_nothing_that_was_there(command, place, theirs, capfd):
    (theirs / "report.txt").write_text("Vehicle 1, a sedan, was travelling north and struck vehicle 2 in the rear.")
    (theirs / "crash.dsl").write_text(CRASH.read_text())
    before = tree(theirs)
    code = main([word.format(PLACES[place]) for word in RESULTS[command]])
    after = tree(theirs)
    assert {name: after.get(name) for name in before} == before
    if code == 2:
        assert after == before
        assert len([line for line in capfd.readouterr().err.splitlines() if line.startswith("roadmend: ")]) == 1


@pytest.mark.parametrize("command", FILES | FOLDERS)
def test_a_full_disk_leaves_nothing_half_written(command, theirs, bank):
    """The disk is full at 300 bytes a file; what is told of it is one line."""
    (theirs / "own.bank").write_bytes(bank)
    before = tree(theirs)
    code = (
        "import resource, signal, sys; from roadmend.cli.main import main\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    given = [word.format("new/mine") for word in (FILES | FOLDERS)[command]]
    environ = {**os.environ, "NUMBA_CACHE_DIR": "", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code, *given], capture_output=True, text=True, env=environ, timeout=120, check=False
    )
    assert done.returncode in {1, 2}, done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert tree(theirs) == before


def test_a_writer_that_fails_at_any_write_leaves_nothing(theirs):
    before = tree(theirs)

    def fail(number):
        with written_beside(theirs / "made" / "for" / "it") as beside:
            for count in range(3):
                with beside.open("a") as file:
                    file.write("some")
                if count == number:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    for number in range(3):
        with pytest.raises(InputError, match="cannot be written \\(No space left on device\\)"):
            fail(number)
        assert tree(theirs) == before


def test_of_files_that_belong_together_none_takes_its_place_where_one_cannot(theirs):
    before = tree(theirs)
    for name in ("foreign", "link-to-text", "pipe"):
        with pytest.raises(InputError, match="cannot be written"):
            write_texts(theirs, {"first": "1", name: "2", "third": "3"})
        assert tree(theirs) == before


def test_a_folder_that_cannot_be_written_stays_as_it_is(theirs, capfd):
    if os.geteuid() == 0:
        pytest.skip("root writes everywhere")
    (theirs / "foreign").chmod(0o500)
    before = tree(theirs)
    assert main(["sample", "--family", "S3", "--out", "foreign/new"]) == 2
    assert tree(theirs) == before
    (theirs / "foreign").chmod(0o700)


def test_of_two_processes_with_one_name_one_gets_it_and_the_other_is_told(theirs):
    given = [sys.executable, "-m", "roadmend.cli", *(word.format("new/mine") for word in FOLDERS["recover"])]
    both = [subprocess.Popen(given, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    told = [process.communicate(timeout=120)[1] for process in both]
    assert {process.returncode for process in both} <= {0, 1, 2}
    assert sum(process.returncode != 0 for process in both) == 1
    assert [len(text.splitlines()) for text in told if text] == [1]
    assert sorted(path.name for path in (theirs / "new").iterdir()) == ["mine"]
