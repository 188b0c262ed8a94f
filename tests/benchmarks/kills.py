"""Kills and stops at random moments: ``.venv/bin/python tests/benchmarks/kills.py COUNT FOLDER``; goes on where it was.

Each run starts ``roadmend run`` in a folder that holds somebody else's files and a bag, and sends one signal to one of its
processes, the launcher's included, at a moment drawn by the seed: from the first 0.1 s, before anything is up, to after
its end. Who was stopped goes on after a while, or is killed then. Afterwards there must be no process of the run, no
temporary folder, each file that was there before as it was, a bag that reads or can be recovered if one was begun, and an
exit code that says what became of the run.
Written are FOLDER/kills.jsonl, and kills.json and kills.md beside this file where ``--publish`` is given.
"""

import argparse
import contextlib
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.core.journal import Journal, entry_key
from roadmend.faults.processes import command_of, end_all, left_of
from roadmend.recording.info import bag_info
from roadmend.recording.recovery import recover
from roadmend.reports.result_files import provenance, write_report
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario

HERE = Path(__file__).parent
SAMPLE = HERE.parents[1] / "bags" / "samples" / "repaired"
SIGNALS = ("KILL", "STOP", "TERM", "INT")
PATIENCE_S = 90.0
GONE_S = 6.0  # [s] in which everything must be gone
LIMIT_S = 6.0  # [s] simulated
LATEST_S = 9.0  # [s] of wall time
CODE = (  # what decides how a run goes, and how it is judged
    "kills",
    *(f"roadmend.cli.{name}" for name in ("main", "run")),
    *(f"roadmend.nodes.{name}" for name in ("launcher", "fork_server", "policy", "recorder", "repair", "sim", "viz")),
    "roadmend.policies.modular",
    "roadmend.repair.rss",
)


def kill(seed: int) -> dict[str, object]:
    """One run with one signal in it, and what was left."""
    numbers = random.Random(f"kill/{seed}")
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        folder = Path(name)
        (folder / "tmp").mkdir()
        owned = _owned(folder / "bags")
        save_scenario(
            sample_scenario(numbers.choice(("S3", "S5")), seed).model_copy(update={"time_limit": LIMIT_S}),
            folder / "s.yaml",
        )
        command = [sys.executable, "-m", "roadmend.cli", "run", "--scenario", str(folder / "s.yaml"), "--no-viz"]
        command += ["--policy", "modular", "--repair", "rss", "--out", str(folder / "bags"), "--name", "bag"]
        command += ["--silence", "2"] + (["--clock", "realtime", "--rate", "2"] if numbers.random() < 0.5 else [])
        environment = {key: value for key, value in os.environ.items() if key != "ROS_DOMAIN_ID"}
        environment["TMPDIR"] = str(folder / "tmp")
        with (folder / "err").open("w") as err:
            process = subprocess.Popen(
                command, stdout=subprocess.DEVNULL, stderr=err, env=environment, start_new_session=True
            )
        mark = f"TMPDIR={folder / 'tmp'}"
        try:
            told = _disturb(process, numbers, mark)
            told["begun"] = _is_begun(folder)
            told |= _left(process, folder, mark, is_begun=bool(told["begun"]))
        finally:
            end_all(mark)
            process.wait()
        said = (folder / "err").read_text(errors="replace")
        told["traceback"] = "Traceback (most recent call last)" in said
        told["changed"] = sorted(path for path, digest in owned.items() if _digest(Path(path)) != digest)
        told["changed"] = [Path(path).name for path in told["changed"]]
        told["bag"] = _bag(folder)
        told["stderr"] = said.splitlines()[-3:]
        return told


def _disturb(process: subprocess.Popen[bytes], numbers: random.Random, mark: str) -> dict[str, object]:
    """Send the signal; whom and when."""
    moment, what = numbers.uniform(0.1, LATEST_S), numbers.choice(SIGNALS)
    wanted, resume = numbers.random(), numbers.choice((None, 0.5, 4.0))
    time.sleep(moment)
    there = sorted(left_of(mark))
    if not there or process.poll() is not None:
        return {"moment": moment, "signal": what, "victim": "", "resume": None}
    victim = process.pid if wanted < 0.3 else numbers.choice(there)
    name = "launcher" if victim == process.pid else _name(victim)
    with contextlib.suppress(ProcessLookupError):
        os.kill(victim, getattr(signal, f"SIG{what}"))
    if what == "STOP":
        time.sleep(resume or 4.0)
        with contextlib.suppress(ProcessLookupError):
            os.kill(victim, signal.SIGCONT if resume else signal.SIGKILL)
    return {"moment": moment, "signal": what, "victim": name, "resume": resume if what == "STOP" else None}


def _left(process: subprocess.Popen[bytes], folder: Path, mark: str, *, is_begun: bool) -> dict[str, object]:
    until = time.monotonic() + PATIENCE_S
    while process.poll() is None:
        is_begun = is_begun or _is_begun(folder)
        if time.monotonic() > until:
            return {"exit_code": None, "left": ["hung"], "begun": is_begun}
        time.sleep(0.02)
    code = process.returncode
    until = time.monotonic() + GONE_S
    while left_of(mark) and time.monotonic() < until:
        time.sleep(0.05)
    left = [f"process {_name(number)}" for number in left_of(mark)]
    left += [f"folder {path.name[:16]}" for path in (folder / "tmp").glob("roadmend-*") if path.is_dir()]
    return {"exit_code": code, "left": left, "begun": is_begun}


def _name(process: int) -> str:
    with contextlib.suppress(OSError):
        own = Path(f"/proc/{process}/comm").read_text().strip()
        return own if own.endswith("_node") else ("helper" if "multiprocessing" in command_of(process) else own)
    return "gone"


def _owned(bags: Path) -> dict[str, str]:
    """Files of somebody else's, and what they hold."""
    shutil.copytree(SAMPLE, bags / "repaired")
    (bags / "notes.txt").write_text("mine\n")
    (bags / "bag.txt").write_text("mine too\n")
    (bags / "empty").mkdir()
    (bags / "empty" / ".keep").touch()
    return {str(path): _digest(path) for path in bags.rglob("*")}


def _digest(path: Path) -> str:
    if path.is_dir():
        return "folder"
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "gone"


def _is_begun(folder: Path) -> bool:
    """Whether the recorder has written into the bag's folder, which the launcher makes."""
    with contextlib.suppress(FileNotFoundError):
        return any(path.stat().st_size for path in (folder / "bags" / "bag").glob("*.mcap"))
    return False


def _bag(folder: Path) -> str:
    """Whether the bag reads, can be recovered, was not begun, or is lost."""
    bag = folder / "bags" / "bag"
    if not bag.exists():
        return "none"
    if not _is_begun(folder):
        return "not begun"
    with contextlib.suppress(InputError):
        if bag_info(bag).complete:
            return "reads"
    try:
        recover(bag, folder / "recovered")
        bag_info(folder / "recovered")
    except InputError as error:
        return f"lost: {error.what}"
    return "recovered"


def wrong_with(told: dict[str, object]) -> list[str]:
    """Why a run is not as it should be."""
    faults = [*told["left"], *(f"changed {name}" for name in told["changed"])]
    if told["traceback"]:
        faults.append("a bare traceback")
    code, bag = told["exit_code"], str(told["bag"])
    if bag.startswith("lost"):
        faults.append(bag)
    elif bag in {"none", "not begun"} and told.get("begun"):
        faults.append("lost: it was begun, and nothing is left of it")
    elif code == 0 and bag != "reads":
        faults.append(f"exit code 0, and of the bag: {bag}")
    if code is not None and code not in _codes(told):
        faults.append(f"exit code {code}")
    return faults


def _codes(told: dict[str, object]) -> set[int]:
    """The exit codes that a run may have: guarantees.md says of each what it means."""
    if not told["victim"]:
        return {0}
    if told["victim"] != "launcher":
        return {0, 1}
    if told["signal"] == "STOP":
        return {0, 1} if told["resume"] else {-signal.SIGKILL}
    # A run that was over in all but name ends with 0; a signal that comes before it is caught ends it as it ends anybody.
    caught = {-getattr(signal, f"SIG{told['signal']}")}
    return caught if told["signal"] == "KILL" else {*caught, 130, 0}


def main() -> int:
    """Run what is missing, and tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--publish", action="store_true")
    given = parser.parse_args()
    found = []
    with Journal(given.folder / "kills.jsonl", "roadmend-kills/1", owns_folder=True) as journal:
        for seed in range(given.count):
            key = entry_key(CODE, seed)
            entry = journal.get(key)
            if entry is None:
                entry = kill(seed)
                journal.add(key, entry)
                print(
                    seed,
                    entry["signal"],
                    entry["victim"],
                    entry["exit_code"],
                    entry["bag"],
                    wrong_with(entry),
                    flush=True,
                )
            found.append(entry)
    if given.publish:
        publish(found, given.count)
    return int(any(wrong_with(each) for each in found))


def publish(found: list[dict[str, object]], count: int) -> None:
    """Write kills.json and kills.md."""
    groups: dict[tuple[str, str], list[dict[str, object]]] = {}
    for each in found:
        groups.setdefault((str(each["victim"]) or "nobody: it was over", str(each["signal"])), []).append(each)
    rows = [
        {
            "victim": victim,
            "signal": name,
            "runs": len(runs),
            "as_it_should_be": sum(not wrong_with(each) for each in runs),
            "bags": dict(Counter(str(each["bag"]).partition(":")[0] for each in runs)),
            "exit_codes": dict(Counter(str(each["exit_code"]) for each in runs)),
            "wrong": dict(Counter(text for each in runs for text in wrong_with(each))),
        }
        for (victim, name), runs in sorted(groups.items())
    ]
    told = [
        [
            "to",
            "signal",
            "runs",
            "nothing left, lost or changed, and the exit code right",
            "bags",
            "exit codes",
            "not as it should be",
        ]
    ]
    for row in rows:
        words = [
            ", ".join(f"{value} {name}" for name, value in row[part].items())
            for part in ("bags", "exit_codes", "wrong")
        ]
        words[1] = ", ".join(f"{name}: {value}" for name, value in row["exit_codes"].items())
        told.append([row["victim"], row["signal"], str(row["runs"]), str(row["as_it_should_be"]), *words])
    told.append(["all", "", str(len(found)), str(sum(not wrong_with(each) for each in found)), "", "", ""])
    content = {
        "format": "roadmend-kills/1",
        "provenance": provenance(f".venv/bin/python tests/benchmarks/kills.py {count} killed --publish"),
        "rows": rows,
        "runs": [each | {"stderr": None} for each in found],
    }
    write_report(HERE, "kills", "Kills and stops at random moments", content, told)


if __name__ == "__main__":
    sys.exit(main())
