"""Hours of driving in one graph: ``.venv/bin/python tests/benchmarks/soak.py HOURS [--minutes WALL] [--long SECONDS]``.

Policy, repair, recorder and markers are started once and stay; episode after episode a simulator joins them, drives in
lockstep, and leaves. With ``--long``, after each round of the families comes a drive of so many seconds, round and round in
a ring road's traffic, both by SUMO's generators. After each one, memory, threads and open files of every process that stays are looked at, and what
the simulator and the repair node counted: in lockstep every tick has its answer, and a tick without one must be explained.
Written are soak.json and soak.md beside this file where ``--publish`` is given. Exit code 1 if memory grew by more than
5 % after the warm-up, or a tick was missed.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.tick import INTERVAL
from roadmend.nodes.domain import own_domain
from roadmend.nodes.loopback import reach
from roadmend.recording.info import bag_info
from roadmend.reports.result_files import provenance, write_report
from roadmend.world.families import sample_scenario
from roadmend.world.procedural_networks import NetworkRequest, generate_configuration
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import save_scenario, scenario_of_configuration

HERE = Path(__file__).parent
FAMILIES = ("S1", "S2", "S3", "S4", "S5")
WARM_UP = 0.2  # share of the episodes that may still grow
GROWTH = 1.05
PATIENCE_S = 600.0  # [s] of wall time for an episode
FILE_SIZE = 64 << 20  # [bytes]
RING = 7  # seed of a network of two rings with six arms
ROUND = [f"C{arm}C{arm % 6 + 1}" for arm in range(1, 7)]  # edges
WARM_UP_S = 300.0  # [s] of traffic
LONGEST_S = 1500.0  # [s] for as long there is traffic
NODES = ("policy", "repair", "recorder", "viz")


class Graph:
    """The nodes that stay."""

    def __init__(self, folder: Path, environment: dict[str, str], method: str, long: Scenario | None) -> None:
        self._folder, self._environment = folder, environment
        self._long = long
        parameters = {
            "policy": {"policy": "modular"},
            "repair": {
                "method": method,
                "policy": "modular",
                "writer": "policy_node",
                "summary": str(folder / "repair.json"),
                "journal": str(folder / "repair.answers"),
            },
            # In files of a size, as whoever records for hours would: the index of an open file is in memory.
            "recorder": {
                "output": str(folder),
                "name": "bag",
                "summary": str(folder / "recorder.json"),
                "max_bagfile_size": FILE_SIZE,
            },
            "viz": {},
        }
        self.nodes = {name: self._start(name, parameters[name]) for name in NODES}

    def _start(self, name: str, parameters: dict[str, object]) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"roadmend.nodes.{name}", "--ros-args"]
        for key, value in parameters.items():
            command += ["-p", f"{key}:={json.dumps(value)}"]
        with (self._folder / f"{name}.log").open("ab") as log:
            return subprocess.Popen(command, stdout=log, stderr=log, env=self._environment)

    def drive(self, number: int) -> dict[str, object] | None:
        """One episode; what the simulator told of it, None where it told nothing."""
        scenario, summary = self._folder / "s.yaml", self._folder / "sim.json"
        save_scenario(self._scenario(number), scenario)
        summary.unlink(missing_ok=True)
        waited = [f"{name}_node" for name in NODES]
        parameters = {"scenario": str(scenario), "summary": str(summary), "writer": "repair_node", "wait_for": waited}
        process = self._start("sim", parameters)
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            pass  # whatever it has told counts
        finally:
            process.kill()  # an interrupt, too, leaves no simulator behind
            process.wait()
        return json.loads(summary.read_text()) if summary.exists() else None

    def _scenario(self, number: int) -> Scenario:
        if self._long is not None and number % (len(FAMILIES) + 1) == len(FAMILIES):
            return self._long
        return sample_scenario(FAMILIES[number % len(FAMILIES)], 70_000 + number)

    def sample(self) -> dict[str, dict[str, int]]:
        """Memory [kB], threads and open files of every node."""
        found = {}
        for name, process in self.nodes.items():
            status = Path(f"/proc/{process.pid}/status").read_text().splitlines()
            values = {line.partition(":")[0]: ([*line.split(), ""])[1] for line in status}
            open_files = len([*Path(f"/proc/{process.pid}/fd").iterdir()])
            found[name] = {"kb": int(values["VmRSS"]), "threads": int(values["Threads"]), "files": open_files}
        return found

    def end(self) -> dict[str, int]:
        """Stop the nodes, the recorder last; their exit codes."""
        codes = {}
        for name in ("viz", "policy", "repair", "recorder"):
            self.nodes[name].send_signal(signal.SIGTERM)
            try:
                codes[name] = self.nodes[name].wait(60)
            except subprocess.TimeoutExpired:
                self.nodes[name].kill()
                codes[name] = self.nodes[name].wait()
        return codes


def long_drive(seconds: float, folder: Path) -> Scenario:
    """Round and round for so long, and no end of the route within it."""
    generate_configuration(NetworkRequest("ring", RING, folder))
    network = folder / f"ring-{RING}" / f"ring-{RING}.net.xml"  # alone it gets lighter traffic than the generator's own
    return scenario_of_configuration(network, ROUND * 40, WARM_UP_S, seconds)


def soak(hours: float, minutes: float, method: str, long: float) -> dict[str, object]:
    """Drive until so much was simulated, or so much wall time is over."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="soak-") as name, own_domain() as domain:
        folder = Path(name)
        environment = {**os.environ, **reach(), "ROS_DOMAIN_ID": str(domain), "TMPDIR": name}
        graph = Graph(folder, environment, method, long_drive(long, folder) if long else None)
        episodes, driven = [], 0.0
        try:
            while driven < 3600.0 * hours and time.monotonic() - begin < 60.0 * minutes:
                told = graph.drive(len(episodes))
                result = EpisodeResult.parse(told["result"]) if told else None
                episodes.append(
                    {
                        "outcome": result.outcome.name if result else "nothing told",
                        "duration": result.duration if result else 0.0,
                        "watchdog_ticks": told["watchdog_ticks"] if told else None,
                        "nodes": graph.sample(),
                    }
                )
                driven += episodes[-1]["duration"]
                dead = [name for name, process in graph.nodes.items() if process.poll() is not None]
                print(
                    len(episodes), round(driven), episodes[-1]["outcome"], _megabytes(episodes[-1]), *dead, flush=True
                )
                if dead:
                    break
        finally:
            codes = graph.end()
        answers = json.loads((folder / "repair.json").read_text())
        info = bag_info(folder / "bag")
        lost = json.loads((folder / "recorder.json").read_text()).get("lost_messages", 0)
    ticks = sum(round(float(each["duration"]) / INTERVAL) + 1 for each in episodes)
    return {
        "hours": driven / 3600.0,
        "wall_minutes": (time.monotonic() - begin) / 60.0,
        "method": method,
        "ticks": ticks,
        "watchdog_ticks": sum(each["watchdog_ticks"] or 0 for each in episodes),
        "answers": {key: value for key, value in answers.items() if key.startswith("state.")},
        "exit_codes": codes,
        "lost_messages": lost,
        "bag_is_complete": info.complete,
        "growth": growth_of(episodes),
        "episodes": episodes,
    }


def _megabytes(episode: dict[str, object]) -> str:
    return " ".join(f"{name} {values['kb'] >> 10} MB" for name, values in episode["nodes"].items())


def growth_of(episodes: list[dict[str, object]]) -> dict[str, float]:
    """By node: memory over the last tenth of the episodes, as a multiple of that right after the warm-up."""
    first = int(WARM_UP * len(episodes))
    span = max(1, len(episodes) // 10)
    found = {}
    for name in NODES:
        memory = [each["nodes"][name]["kb"] for each in episodes]
        before, after = memory[first : first + span], memory[-span:]
        found[name] = (sum(after) / len(after)) / (sum(before) / len(before))
    return found


def main() -> int:
    """Soak, and tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hours", type=float)
    parser.add_argument("--minutes", type=float, default=600.0)
    parser.add_argument("--repair", default="adreft")
    parser.add_argument(
        "--long", type=float, default=0.0, help=f"[s] of a long drive after each round, {LONGEST_S:g} at most"
    )
    parser.add_argument("--publish", action="store_true")
    given = parser.parse_args()
    if not 0.0 <= given.long <= LONGEST_S:
        parser.error(f"--long is from 0 to {LONGEST_S:g}")
    found = soak(given.hours, given.minutes, given.repair, given.long)
    stale = {key: count for key, count in found["answers"].items() if "STALE" in key or "FAULT" in key}
    print(json.dumps({key: value for key, value in found.items() if key != "episodes"}, indent=1))
    if given.publish:
        publish(found, " ".join(sys.argv[1:]))
    missed = found["ticks"] - sum(found["answers"].values())
    is_bad = any(value > GROWTH for value in found["growth"].values()) or found["watchdog_ticks"] or stale or missed
    return int(bool(is_bad))


def publish(found: dict[str, object], words: str) -> None:
    """Write soak.json and soak.md."""
    first, last = found["episodes"][int(WARM_UP * len(found["episodes"]))], found["episodes"][-1]
    rows = [["node", "after the warm-up [MB]", "at the end [MB]", "growth", "threads", "open files", "exit code"]]
    for name in NODES:
        one, other = first["nodes"][name], last["nodes"][name]
        rows.append(
            [
                f"{name}_node",
                f"{one['kb'] / 1024:.1f}",
                f"{other['kb'] / 1024:.1f}",
                f"{100.0 * (found['growth'][name] - 1.0):+.1f} %",
                f"{one['threads']}, {other['threads']}",
                f"{one['files']}, {other['files']}",
                str(found["exit_codes"][name]),
            ]
        )
    answers = ", ".join(f"{value} {key.removeprefix('state.')}" for key, value in found["answers"].items())
    more = [
        ["driven [h]", "wall [min]", "episodes", "ticks", "missed by repair_node", "lost messages", "answers", "bag"],
        [
            f"{found['hours']:.2f}",
            f"{found['wall_minutes']:.1f}",
            str(len(found["episodes"])),
            str(found["ticks"]),
            str(found["watchdog_ticks"]),
            str(found["lost_messages"]),
            answers,
            "complete" if found["bag_is_complete"] else "not complete",
        ],
    ]
    content = {
        "format": "roadmend-soak/1",
        "provenance": provenance(f".venv/bin/python tests/benchmarks/soak.py {words}"),
    }
    write_report(HERE, "soak", "Hours in one graph", content | found, rows, more)


if __name__ == "__main__":
    sys.exit(main())
