"""The script at the root of a clone, as a stranger calls it: help, completion, and Ctrl-C in the middle of work."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "roadmend"
PATIENCE = 240.0  # [s] on a machine that has other things to do

pytestmark = pytest.mark.skipif(
    not (ROOT / ".venv" / "stamps" / "kernels").exists(), reason="this clone is not set up by its script"
)


def call(*words, **variables):
    return subprocess.run(
        ["./roadmend", *words],
        cwd=ROOT,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
    )


def test_alone_it_prints_its_help():
    done = call()
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("Usage: ./roadmend ")
    assert "\n  ./roadmend demo\n" in done.stdout
    assert "\n  set-up  " in done.stdout


@pytest.mark.parametrize("command", ["set-up", "test"])
def test_what_the_script_does_itself_has_help_too(command):
    done = call(command, "--help")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"Usage: ./roadmend {command} ")
    assert f"Examples:\n  ./roadmend {command}\n" in done.stdout


@pytest.mark.graph
def test_a_replay_that_waits_says_for_whom_and_ends_with_130_when_interrupted():
    command = ["./roadmend", "replay", "bags/samples/repaired", "--lockstep"]
    running = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    assert any("waiting for a node that answers on /repair/" in line for line in running.stderr)
    running.send_signal(signal.SIGINT)
    assert running.communicate(timeout=PATIENCE)[1].endswith("roadmend: interrupted\n")
    assert running.returncode == 130


def test_a_misspelled_command_gets_the_nearest_name():
    done = call("tset")
    assert done.returncode == 2
    assert "Did you mean" in done.stderr
    assert "'test'" in done.stderr


def test_it_answers_a_shell_that_completes():
    done = call(_ROADMEND_COMPLETE="bash_complete", COMP_WORDS="./roadmend bag res", COMP_CWORD="2")
    assert (done.returncode, done.stdout, done.stderr) == (0, "plain,resimulate\n", "")


def test_a_shell_that_completes_sets_nothing_up(tmp_path):
    (tmp_path / "roadmend").write_bytes(SCRIPT.read_bytes())
    for name in ("config/requirements", "msg"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).symlink_to(ROOT / name)
    environment = {**os.environ, "_ROADMEND_COMPLETE": "bash_complete"}
    done = subprocess.run(["python3", str(tmp_path / "roadmend")], env=environment, capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (1, b"", b"")
    assert not (tmp_path / ".venv").exists()


@pytest.mark.slow
def test_work_that_is_interrupted_says_how_to_go_on_and_goes_on(tmp_path):
    out = tmp_path / "measured here"
    words = ["evaluate", "--family", "S3", "--count", "40", "--repair", "none", "--workers", "2", "--out", str(out)]
    process = subprocess.Popen(
        ["./roadmend", *words],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    results = out / "results.jsonl"
    begin = time.monotonic()
    while not (results.exists() and results.read_bytes().count(b"\n") > 2):  # its head, and two episodes
        assert process.poll() is None
        assert time.monotonic() - begin < PATIENCE
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: the workers hear it too
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, said
    lines = [line for line in said.splitlines() if line]
    command = f"./roadmend evaluate --family S3 --count 40 --repair none --workers 2 --out '{out}'"
    assert lines[-1] == f"roadmend: interrupted; what is finished is kept, go on with: {command}"
    assert "Traceback" not in said
    kept = results.read_bytes()
    again = subprocess.Popen(command, shell=True, cwd=ROOT, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    begin = time.monotonic()
    while len(results.read_bytes()) <= len(kept):
        assert again.poll() is None
        assert time.monotonic() - begin < PATIENCE
        time.sleep(0.05)
    again.send_signal(signal.SIGINT)
    again.wait(PATIENCE)
    assert results.read_bytes().startswith(kept)  # nothing is driven again
