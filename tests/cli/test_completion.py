"""Completion: what a shell is told, and that a real bash makes use of it."""

import os
import shutil
import subprocess
import sys

import pytest

from roadmend.cli.main import main

CALL = "import sys; from roadmend.cli.main import main; sys.exit(main(sys.argv[1:]))"


def asked(words, last, variables=None):
    """What the command line answers a bash that has ``words`` and completes the last one."""
    line = f"roadmend {words} {last}".replace("  ", " ")
    environment = {
        **os.environ,
        "_ROADMEND_COMPLETE": "bash_complete",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(line.split(" ")) - 1),
        **(variables or {}),
    }
    done = subprocess.run([sys.executable, "-c", CALL], env=environment, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return [each.partition(",")[2] if each.startswith("plain") else each for each in done.stdout.split()]


@pytest.mark.parametrize(
    ("words", "last", "answers"),
    [
        ("", "ev", ["evaluate"]),
        ("", "s", ["sample", "schema", "search", "safe", "sera", "set-up"]),
        ("bag", "re", ["recover", "resimulate"]),
        ("sera bank", "ex", ["export"]),
        ("sample", "--fam", ["--family"]),
        ("sample --family", "S", ["S1", "S2", "S3", "S4", "S5"]),
        ("corpus show --policy", "mod", ["modular"]),
        ("sample --out", "x", ["file,x"]),
    ],
)
def test_commands_options_names_and_files(words, last, answers):
    assert asked(words, last) == answers


def test_commands_are_completed_without_loading_one():
    code = CALL.replace("sys.exit(", "import atexit; atexit.register(lambda: print(*sys.modules)); sys.exit(")
    environment = {**os.environ, "_ROADMEND_COMPLETE": "bash_complete", "COMP_WORDS": "roadmend s", "COMP_CWORD": "1"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert "plain,sample" in done.stdout
    assert not {"numpy", "roadmend.cli.scenario"} & set(done.stdout.split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_gets_its_script(shell, capfd):
    assert main(["completion", shell]) == 0
    printed = capfd.readouterr().out
    assert f"_ROADMEND_COMPLETE={shell}_complete" in printed
    assert "roadmend" in printed


def test_an_unknown_shell_is_refused(capsys):
    assert main(["completion", "csh"]) == 2
    assert "'csh' is not one of" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_a_real_bash_completes_the_script_of_a_clone(tmp_path, capfd):
    assert main(["completion", "bash"]) == 0
    (tmp_path / "roadmend").write_text(f'#!/bin/sh\nexec "{sys.executable}" -P -m roadmend.cli "$@"\n')
    (tmp_path / "roadmend").chmod(0o755)
    call = 'COMP_WORDS=(./roadmend bag res); COMP_CWORD=2; _roadmend_completion ./roadmend; echo "${COMPREPLY[@]}"'
    script = f"{capfd.readouterr().out}\ncomplete -p roadmend\n{call}"
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "-F _roadmend_completion roadmend" in done.stdout
    assert done.stdout.split()[-1] == "resimulate"
