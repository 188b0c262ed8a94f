"""Damaged files given to every command that reads one: what the command says, what it takes, and what it leaves."""

import hashlib
import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from roadmend.core.parameters import Parameters
from roadmend.core.resources import config_folder
from roadmend.faults.damage import DAMAGES
from roadmend.faults.file_kinds import FILES, SCENARIO, VARIED, FileKind
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario

_PATIENCE_S = 120
# What a process has had at most, it is said to have had before it became what it runs: a command that began out of this
# one would be weighed with all that this one ever held. So it begins out of one that holds next to nothing.
_WEIGH = """
import os, signal, sys
null = (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)
process = os.posix_spawn(sys.argv[2], sys.argv[2:], os.environ, file_actions=[null])
signal.signal(signal.SIGALRM, lambda *_: os.kill(process, signal.SIGKILL))
signal.alarm(int(sys.argv[1]))
_, status, used = os.wait4(process, 0)
print(os.waitstatus_to_exitcode(status), used.ru_maxrss)
"""


class FileCampaign(Parameters):
    """Kinds of files times damages."""

    kinds: tuple[str, ...] = Field(tuple(FILES), min_length=1, description="of files")
    damages: tuple[str, ...] = Field(tuple(DAMAGES), min_length=1, description="of each")
    flips: int = Field(3, ge=1, le=1000, description="files that are cut or flipped, each in another way")

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name, given, known in (("kinds", self.kinds, FILES), ("damages", self.damages, DAMAGES)):
            for one in given:
                if one not in known:
                    raise ValueError(f"{name}: {one!r} is none of {', '.join(known)}")
        return self


@dataclass(frozen=True)
class FileTrial:
    """One damaged file, given to one command."""

    kind: str
    damage: str  # empty: none
    seed: int = 0

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return dict(vars(self))


@dataclass(frozen=True)
class Refused:
    """What came of it.

    Attributes:
        exit_code: of the command; None if it hung and was killed.
        lines: on standard error.
        traceback: whether they show a bare one.
        seconds: of wall time.
        memory: most that the process had [KiB], whatever this one has.
        is_tree_whole: whether the folder holds what it held before, but for what was asked for.
        stderr: its last lines.
    """

    exit_code: int | None
    lines: int
    traceback: bool
    seconds: float
    memory: int
    is_tree_whole: bool
    stderr: tuple[str, ...] = field(default=())

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return vars(self) | {"stderr": list(self.stderr)}

    @classmethod
    def parse(cls, entry: Mapping[str, Any]) -> "Refused":
        """From ``as_dict``."""
        return cls(**{**entry, "stderr": tuple(entry["stderr"])})


def file_trials(campaign: FileCampaign) -> list[FileTrial]:
    """The sound file of each kind first, then its damaged ones."""
    found = []
    for kind in campaign.kinds:
        found.append(FileTrial(kind, ""))
        for damage in campaign.damages:
            found += [FileTrial(kind, damage, seed) for seed in range(campaign.flips if damage in VARIED else 1)]
    return found


class FileBench:
    """Makes each sound file once, and gives damaged ones to commands."""

    def __init__(self) -> None:
        self._sound: dict[str, bytes] = {}
        self._made: dict[tuple[Sequence[str], ...], dict[str, bytes]] = {}

    def give(self, trial: FileTrial) -> Refused:
        """Run the command of a kind over a file.

        Raises:
            RuntimeError: no sound file of the kind can be made here.
        """
        kind = FILES[trial.kind]
        if trial.kind not in self._sound:
            self._sound[trial.kind] = self._make(kind)
        with tempfile.TemporaryDirectory(prefix="roadmend-files-") as name:
            folder = Path(name)
            file = folder / "given" / kind.name
            file.parent.mkdir()
            save_scenario(sample_scenario("S3", 7), folder / "given" / SCENARIO)
            for place in kind.beside:
                (file.parent / Path(place).name).write_bytes(self._made[tuple(kind.made)][place])
            if trial.damage:
                DAMAGES[trial.damage](file, self._sound[trial.kind], trial.seed)
            else:
                file.write_bytes(self._sound[trial.kind])
            (folder / "tmp").mkdir()
            before = _tree(folder / "given")
            done = _run(kind.read, folder, file)
            left = [path for path in (folder / "tmp").glob("roadmend-*") if path.is_dir()]
            is_whole = _tree(folder / "given") == before and not left
            is_whole = is_whole and not (done.exit_code == 2 and (folder / "out").exists())
            return Refused(done.exit_code, done.lines, done.traceback, done.seconds, done.memory, is_whole, done.stderr)

    def _make(self, kind: FileKind) -> bytes:
        if kind.copied:
            return (config_folder() / kind.copied).read_bytes()
        with tempfile.TemporaryDirectory(prefix="roadmend-files-") as name:
            folder = Path(name)
            (folder / "given").mkdir()
            (folder / "tmp").mkdir()
            save_scenario(sample_scenario("S3", 7), folder / "given" / SCENARIO)
            if not kind.at:
                return (folder / "given" / SCENARIO).read_bytes()
            key = tuple(kind.made)
            if key not in self._made:
                for words in kind.made:
                    done = _run(words, folder, folder / "none")
                    if done.exit_code:
                        raise RuntimeError(f"{' '.join(words)}: {' '.join(done.stderr)}")
                made = folder / "made"
                self._made[key] = {
                    str(path.relative_to(made)): path.read_bytes() for path in made.rglob("*") if path.is_file()
                }
            return self._made[key][kind.at]


def _run(words: Sequence[str], folder: Path, file: Path) -> Refused:
    places = {
        "file": str(file),
        "out": str(folder / "out"),
        "made": str(folder / "made"),
        "scenario": str(folder / "given" / SCENARIO),
        "report": str(config_folder() / "reports" / "straight"),
    }
    (folder / "made").mkdir(exist_ok=True)
    command = [sys.executable, "-m", "roadmend.cli", *(word.format(**places) for word in words)]
    environment = {**os.environ, "TMPDIR": str(folder / "tmp")}
    begin = time.monotonic()
    with (folder / "err").open("w") as err:
        process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", _WEIGH, str(_PATIENCE_S), *command],
            stdout=subprocess.PIPE,
            stderr=err,
            env=environment,
            start_new_session=True,
            cwd=folder,
        )
        try:
            told, _ = process.communicate()
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)  # the command too, which is this one's child no longer
            raise
    code, memory = map(int, told.split())
    said = (folder / "err").read_text(encoding="utf-8", errors="replace").splitlines()
    return Refused(
        None if code < 0 else code,
        len(said),
        any("Traceback (most recent call last)" in line for line in said),
        time.monotonic() - begin,
        memory,
        is_tree_whole=True,
        stderr=tuple(said[-4:]),
    )


def _tree(folder: Path) -> dict[str, tuple[int, int, str]]:
    """Of all below a folder: mode, size, and what is in it or where it points."""
    found = {}
    for path in sorted(folder.rglob("*")):
        state = path.lstat()
        content = ""
        if stat.S_ISLNK(state.st_mode):
            content = str(path.readlink())
        elif stat.S_ISREG(state.st_mode) and state.st_size < 1 << 30:
            content = hashlib.sha256(path.read_bytes()).hexdigest()
        found[str(path.relative_to(folder))] = (state.st_mode, state.st_size, content)
    return found
